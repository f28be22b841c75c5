# What CI runs: everything that must hold. `.ci/run` is the one list of its steps.
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
    RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps

# The example of the README.
example:
    cargo run --release -- calibrate examples/hand-held

# Instructions per step of the velocity estimators and of the compensation; needs valgrind.
instructions:
    cargo build --release -p proofmass-core --example step_cost
    python3 bench/instructions.py
