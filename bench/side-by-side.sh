#!/usr/bin/env bash
# Saltus and other solvers of the same model, interleaved: bench/side-by-side.sh DIR [ROUNDS]
# DIR holds the others, built as bench/README.md describes.
set -euo pipefail
others=$(realpath "${1:?usage: bench/side-by-side.sh DIR [ROUNDS]}")
rounds=${2:-3}
cd "$(dirname "$0")/.."
target=$(realpath -m "${CARGO_TARGET_DIR:-target}")
(cd studies && CARGO_TARGET_DIR=$target cargo build --quiet --release --bin speed)
speed=$target/release/speed
export JUMPS="$PWD/tests/reference/jumps.csv"
# Lines are chosen by sed, which reads to the end: a reader that stops early would end the writer, and with it this script.
for _ in $(seq "$rounds"); do
    "$speed"
    (cd "$others/A" && ./best | sed -n 1p && ./offgrid | sed -n '/^hand.*tol 2e-09/p')
    (cd "$others/B" && ./table | sed -n '/tol 2e-09/p')
done
