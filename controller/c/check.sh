#!/usr/bin/env bash
# The exported C on this machine gives the answers of the Rust code to the bit: over the drill of the firmware, with approach rates that
# count at the reference lean and at the firing angle; and over the drills of running, of learnt tables and of balls, in both
# types of numbers, with a simulated ball's run.
#
#     bash controller/c/check.sh [DECISIONS [CYCLES]]
#
# Ends with 3 where there is no C compiler.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
command -v cc >/dev/null || exit 3
decisions=${1:-100000}
cycles=${2:-1000000}
tables=controller/examples/rats_planar
build=${CARGO_TARGET_DIR:-target}/c-drill
mkdir -p "$build"
for at_firing in 0 1; do
    sed "s/^#define AT_FIRING .*/#define AT_FIRING $at_firing/" "$tables/saltus_controller.c" >"$build/saltus_controller.c"
    cc -std=c99 -O2 -fno-math-errno -Wall -Wextra -Werror -DDECISIONS="$decisions" -I"$tables" -Icontroller/firmware \
        controller/firmware/{main,drill}.c "$build/saltus_controller.c" -lm -o "$build/drill"
    # The numbers of the self-test are those of the tables as exported.
    "$build/drill" | grep -v '^self-test' >"$build/c.txt" || true
    cargo run --quiet --release --locked -p saltus-controller --example drill -- "$decisions" "$at_firing" >"$build/rust.txt"
    diff "$build/c.txt" "$build/rust.txt" || { printf 'the exported C and Rust disagree\n' >&2; exit 1; }
done
cat "$build/rust.txt"
for real in float double; do
    bash controller/c/filled.sh "$real" "$build"
    cc -std=c99 -O2 -fno-math-errno -Wall -Wextra -Werror -DCYCLES="$cycles" -I"$build" -Icontroller/firmware \
        controller/firmware/running.c "$build/saltus_running.c" -lm -o "$build/running"
    "$build/running" >"$build/c.txt"
    cargo run --quiet --release --locked -p saltus-controller --example running_drill -- "$cycles" "$real" >"$build/rust.txt"
    diff "$build/c.txt" "$build/rust.txt" || { printf 'running in C and in Rust disagree\n' >&2; exit 1; }
    printf 'running, %s: ' "$real"
    cat "$build/rust.txt"
    cc -std=c99 -O2 -fno-math-errno -Wall -Wextra -Werror -DSTATES="$cycles" -I"$build" -Icontroller/firmware \
        controller/firmware/policy.c -o "$build/policy"
    "$build/policy" >"$build/c.txt"
    cargo run --quiet --release --locked -p saltus-controller --example policy_drill -- "$cycles" "$real" >"$build/rust.txt"
    diff "$build/c.txt" "$build/rust.txt" || { printf 'learnt tables in C and in Rust disagree\n' >&2; exit 1; }
    printf 'learnt tables, %s: ' "$real"
    cat "$build/rust.txt"
    cc -std=c99 -O2 -fno-math-errno -Wall -Wextra -Werror -DCYCLES="$cycles" -I"$build" -Icontroller/firmware \
        controller/firmware/ball.c "$build/saltus_ball.c" -lm -o "$build/ball"
    "$build/ball" >"$build/c.txt"
    cargo run --quiet --release --locked -p saltus-controller --example ball_drill -- "$cycles" "$real" >"$build/rust.txt"
    diff "$build/c.txt" "$build/rust.txt" || { printf 'a ball in C and in Rust disagrees\n' >&2; exit 1; }
    printf 'a ball, %s: ' "$real"
    cat "$build/rust.txt"
    cargo run --quiet --release --locked -p saltus --example ball_replay -- 60 "$real" "$build/replay" >"$build/rust.txt"
    cc -std=c99 -O2 -fno-math-errno -Wall -Wextra -Werror -I"$build/replay" -Icontroller/firmware controller/firmware/ball_replay.c \
        "$build/replay/saltus_ball.c" -lm -o "$build/replayed"
    "$build/replayed" >"$build/c.txt"
    diff "$build/c.txt" "$build/rust.txt" || { printf 'a simulated ball in C and in Rust disagrees\n' >&2; exit 1; }
    printf 'a simulated ball, %s: ' "$real"
    cat "$build/rust.txt"
done
printf 'the same to the bit in C and in Rust\n'
