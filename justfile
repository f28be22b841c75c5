# What CI runs: everything that must hold.
check: format lint test docs embedded features licences

# Formatting.
format:
    cargo fmt --all --check

# Clippy, warnings denied.
lint:
    cargo clippy --workspace --all-targets -- -D warnings

# All tests.
test:
    cargo test --workspace

# Documentation, warnings denied.
docs:
    RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps

# The crate for firmware, on a bare-metal target.
embedded:
    rustup target add thumbv7em-none-eabihf
    cargo build -p proofmass-core --target thumbv7em-none-eabihf

# Each crate by itself, as a user of one crate builds it.
features:
    for c in core uncertainty signal noise calibration motion rig fixture io report; do cargo check -q -p proofmass-$c || exit 1; done

# Licences of all dependencies.
licences:
    python3 .ci/licences.py

# The example of the README.
example:
    cargo run --release -- calibrate examples/hand-held

# Instructions per step of the velocity estimators and of the compensation; needs valgrind.
instructions:
    cargo build --release -p proofmass-core --example step_cost
    python3 bench/instructions.py
