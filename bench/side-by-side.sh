#!/usr/bin/env bash
# Saltus and other solvers of the same model, interleaved: bench/side-by-side.sh PEERS_DIR [ROUNDS]
set -euo pipefail
peers=$(realpath "${1:?usage: bench/side-by-side.sh PEERS_DIR [ROUNDS]}")
rounds=${2:-3}
cd "$(dirname "$0")/.."
cargo build --quiet --release -p saltus-planner --example speed
export JUMPS="$PWD/tests/reference/jumps.csv"
for _ in $(seq "$rounds"); do
    target/release/examples/speed
    (cd "$peers/A" && ./best | head -1 && ./offgrid | grep 'tol 2e-09' | head -1)
    (cd "$peers/B" && ./table | grep 'tol 2e-09')
done
