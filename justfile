# What CI runs: what every change must hold, and short forms of the campaigns below. `.ci/run` is the one list of its steps.
check:
    .ci/run

# Formatting.
format:
    cargo fmt --all --check

# Clippy, warnings denied.
lint:
    cargo clippy --workspace --all-targets -- -D warnings

# All tests.
test:
    cargo test --workspace

# Tests against recordings of others, in the folder of PROOFMASS_REFERENCE_DATA.
test-recordings:
    cargo test --workspace --tests -- --ignored

# Documentation, warnings denied.
docs:
    RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --all-features

# The book, in target/book; needs mdBook.
book:
    mdbook build

# Pages that are written from the program.
pages:
    cargo run -p proofmass-jobs --example pages
    cargo run -p proofmass-cli --example commands_page
    cargo run -p proofmass-jobs --features schema --example schemas
    PROOFMASS_WRITE_PAGES=1 cargo test --workspace --test every_job

# The picture of the first report, in docs/report.png; needs Chromium.
picture:
    cargo run --release -- calibrate examples/hand-held
    chromium --headless --no-sandbox --hide-scrollbars --window-size=800,1450 --screenshot=docs/report.png "file://$PWD/examples/hand-held/result/report.html"

# The example of the README.
example:
    cargo run --release -- calibrate examples/hand-held

# Two builds from two folders are the same to the byte.
reproducible:
    .ci/reproducible

# Fuzzing, so many seconds for each target.
fuzz seconds="60":
    .ci/fuzz {{seconds}}

# Fuzzing from the seeds of each format by itself, an hour each.
fuzz-readers seconds="3600":
    .ci/fuzz {{seconds}} readers

# So many random uncertainty models against GTC and numpy.
models count="600":
    .ci/models {{count}}

# A run is killed at, or refused by, each call in turn; needs strace.
faults:
    .ci/faults --all

# Every seed of the fuzzer's corpus damaged in so many ways.
mutations count="20000":
    PROOFMASS_MUTATIONS={{count}} cargo test --workspace --test mutations

# Ten commands, each killed so often at random instants.
kills count="50":
    PROOFMASS_KILLS={{count}} cargo test -p proofmass-cli --test killed_commands -- --nocapture

# Records: a writer killed so often, so many bits flipped; then speed with 10⁵ calibrations of 10⁴ devices.
records kills="200" bits="200":
    cargo run --release -p proofmass-records --example survival -- {{kills}} {{bits}}
    cargo run --release -p proofmass-records --example speed

# The coverage maps of the documents, or those whose name holds a word; hours for all.
maps only="":
    .ci/maps "{{only}}"

# Instructions per step of the velocity estimators and of the compensation; needs valgrind.
instructions:
    cargo build --release -p proofmass-core --example step_cost
    python3 bench/instructions.py

# The JSON schemas against the program, on files that ship and what comes of them when a place is changed.
schemas:
    .ci/schemas

# What is published beside the crates: archive, Debian package, container image, list of what is linked; in target/packages.
packages:
    packaging/build

# The crates as they would be published, built and tested from each other alone.
packages-unpacked:
    packaging/unpacked

# Everything that a publication would do, but for the publication.
publish-dry-run:
    cargo publish --workspace --dry-run --locked

# The Python package: its tests, then wheel and source archive as they are published.
wheel:
    .ci/python --wheel

# The typesetter of certificates: its tests.
certificate:
    .ci/certificate
