#!/usr/bin/env bash
# The exported C on a Cortex-M4F in QEMU: answers to the bit as the Rust code's on this machine, instructions, memory, stack.
#
#     bash controller/firmware/run.sh [DECISIONS [CYCLES]]
#
# The Rust programs of learnt tables and balls are in studies/, which takes minutes to build.
# Ends with 3 where compiler or emulator are missing or do not start. TOOLS may name a folder into which `tools.sh` has unpacked both.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

decisions=${1:-20000}
cycles=${2:-200000}
tools=${TOOLS:-}
tables=controller/examples/rats_planar
target=$(realpath -m "${CARGO_TARGET_DIR:-target}")
build=$target/firmware-drill
mkdir -p "$build"

# A program of studies/.
study() {
    (cd studies && CARGO_TARGET_DIR=$target cargo run --quiet --release --locked --bin "$1" -- "${@:2}")
}

# Programs of the unpacked packages find their libraries beside them.
with_tools() {
    if [ -n "$tools" ]; then
        local libraries
        libraries=$(printf '%s:' "$tools"/usr/lib/*-linux-gnu* "$tools"/lib/*-linux-gnu*)
        LD_LIBRARY_PATH="${libraries%:}" PATH="$tools/usr/bin:$PATH" "$@"
    else
        "$@"
    fi
}

# A tool that does not start is missing; it says nothing about the controller.
starts() {
    with_tools "$@" </dev/null >"$build/starts.txt" 2>&1 && return
    printf '%s does not start: %s\n' "$1" "$(head -1 "$build/starts.txt")" >&2
    exit 3
}
starts arm-none-eabi-gcc -mcpu=cortex-m4 -x c -c -o "$build/empty.o" -
starts qemu-system-arm -machine none -version

flags=(-mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16 -std=c99 -O2 -fno-math-errno -ffunction-sections -fdata-sections
    -Wall -Wextra -Werror -I"$tables")
specs=rdimon.specs
if [ -n "$tools" ]; then
    library=$tools/usr/lib/arm-none-eabi/newlib/$(with_tools arm-none-eabi-gcc "${flags[@]}" -print-multi-directory)
    flags+=(-isystem "$tools/usr/include/newlib" -L"$library")
    specs=$library/rdimon.specs
fi

printf 'On %s, %s:\n' "$(with_tools arm-none-eabi-gcc --version | head -1)" "$(with_tools qemu-system-arm --version | head -1)"

# Alone: what code takes in flash and memory, and what it calls. Nothing: no heap, no library.
alone() {
    local name=$1 source=$2
    with_tools arm-none-eabi-gcc "${flags[@]}" -I"$build" -DSALTUS_NO_SELF_TEST -fstack-usage -c "$source" -o "$build/$name.o"
    with_tools arm-none-eabi-size "$build/$name.o" |
        awk -v name="$name" 'NR == 2 { printf "%s: flash %d bytes, memory %d bytes\n", name, $1 + $2, $2 + $3 }'
    missing=$(with_tools arm-none-eabi-nm --undefined-only "$build/$name.o" | awk '{ print $2 }')
    [ -z "$missing" ] || { printf 'the %s calls %s\n' "$name" "$missing" >&2; exit 1; }
    if grep -E 'dynamic' "$build/$name.su"; then printf 'the stack has no bound\n' >&2; exit 1; fi
}
bash controller/c/filled.sh float "$build"
alone controller "$tables/saltus_controller.c"
alone running "$build/saltus_running.c"
alone ball "$build/saltus_ball.c"
printf 'no undefined symbol: no allocation, no library\n'

# The drill in the emulator: one instruction takes 64 ns of its time.
data=()
[ -z "$tools" ] || data=(-L "$tools/usr/share/qemu")
emulated() {
    with_tools arm-none-eabi-gcc "${flags[@]}" -I"$build" -Wno-array-bounds -nostartfiles --specs="$specs" \
        -T controller/firmware/mps2.ld -Wl,--gc-sections controller/firmware/start.c "$@" -o "$build/drill.elf"
    with_tools timeout 900 qemu-system-arm -M mps2-an386 -icount shift=6 -nographic -monitor none -serial none \
        -semihosting-config enable=on,target=native "${data[@]}" -kernel "$build/drill.elf" </dev/null
}
emulated -DDECISIONS="$decisions" controller/firmware/{main,drill}.c "$tables/saltus_controller.c" >"$build/emulated.txt"
emulated -DCYCLES="$cycles" controller/firmware/running.c "$build/saltus_running.c" >"$build/running.txt"
emulated -DSTATES="$cycles" controller/firmware/policy.c >"$build/policy.txt"
emulated -DCYCLES="$cycles" controller/firmware/ball.c "$build/saltus_ball.c" >"$build/ball.txt"
# Seconds of a simulated run: 26 bytes a cycle, of a megabyte.
seconds=$((cycles < 30000 ? cycles / 1000 : 30))
study ball_replay "$seconds" float "$build/replay" >"$build/rust_replay.txt"
emulated -I"$build/replay" controller/firmware/ball_replay.c "$build/replay/saltus_ball.c" >"$build/replay.txt"
sed -n 's/^# //p' "$build/replay.txt" "$build/emulated.txt" "$build/running.txt" "$build/policy.txt" "$build/ball.txt"

# The same in Rust on this machine.
cargo run --quiet --release --locked -p saltus-controller --example drill -- "$decisions" >"$build/rust.txt"
{ echo 'self-test: 0'; cat "$build/rust.txt"; } >"$build/expected.txt"
cargo run --quiet --release --locked -p saltus-controller --example running_drill -- "$cycles" >"$build/rust_running.txt"
grep -v '^#' "$build/running.txt" | diff - "$build/rust_running.txt" || { printf 'running on a Cortex-M4F and in Rust disagrees\n' >&2; exit 1; }
study policy_drill "$cycles" >"$build/rust_policy.txt"
grep -v '^#' "$build/policy.txt" | diff - "$build/rust_policy.txt" || { printf 'a learnt table on a Cortex-M4F and in Rust disagrees\n' >&2; exit 1; }
study ball_drill "$cycles" >"$build/rust_ball.txt"
grep -v '^#' "$build/ball.txt" | diff - "$build/rust_ball.txt" || { printf 'a ball on a Cortex-M4F and in Rust disagrees\n' >&2; exit 1; }
grep -v '^#' "$build/replay.txt" | diff - "$build/rust_replay.txt" || { printf 'a simulated ball on a Cortex-M4F and in Rust disagrees\n' >&2; exit 1; }
grep -v '^#' "$build/emulated.txt" | diff - "$build/expected.txt" || { printf 'Cortex-M4F and Rust disagree\n' >&2; exit 1; }
cat "$build/rust.txt" "$build/rust_running.txt" "$build/rust_policy.txt" "$build/rust_ball.txt" "$build/rust_replay.txt"
printf 'the same to the bit on Cortex-M4F and in Rust on this machine\n'

# Bounds that hold for every input seen.
worst() { sed -n "s/^# $1: instructions median [0-9]*, worst \([0-9]*\)$/\1/p" "$build/emulated.txt" "$build/running.txt" "$build/policy.txt" "$build/ball.txt" "$build/replay.txt"; }
median() { sed -n "s/^# $1: instructions median \([0-9]*\),.*$/\1/p" "$build/emulated.txt"; }
[ "$(worst decisions)" -lt 2000 ] || { printf 'a decision took 2000 instructions or more\n' >&2; exit 1; }
[ "$(worst decisions)" -le $((3 * $(median decisions))) ] || { printf 'the worst decision took over 3 times the median\n' >&2; exit 1; }
[ "$(worst cycles)" -lt 3000 ] || { printf 'a cycle of running took 3000 instructions or more\n' >&2; exit 1; }
[ "$(worst balls)" -le 8000 ] && [ "$(worst replay)" -le 8000 ] || { printf 'a cycle of a ball took more than 8000 instructions\n' >&2; exit 1; }
[ "$(worst choices)" -le 500 ] || { printf 'a choice took more than 500 instructions\n' >&2; exit 1; }
