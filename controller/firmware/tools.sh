#!/usr/bin/env bash
# Unpacks Debian's cross compiler and emulator, with every package that they need, into a folder. Nothing is installed.
#
#     bash controller/firmware/tools.sh FOLDER
set -euo pipefail
mkdir -p "$1"
folder=$(realpath "$1")
[ -e "$folder/complete" ] && exit 0
packages=(gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm)
# The closure as on a system without any package: what happens to be installed here makes no difference. Only the C library is the
# system's own, because its version and that of the dynamic loader must agree.
closure() {
    apt-get install --simulate --no-install-recommends -o Dir::State::status=/dev/null "${packages[@]}" 2>/dev/null |
        awk '/^Inst/ && $2 != "libc6" { print $2 }'
}
names=$(closure) || { apt-get update >/dev/null && names=$(closure); }
mkdir -p "$folder/packages" && cd "$folder/packages"
# Lists that are old name packages that are no longer there.
apt-get download $names >/dev/null || { apt-get update >/dev/null && apt-get download $(closure) >/dev/null; }
for package in *.deb; do
    dpkg --extract "$package" "$folder"
    rm "$package"
done
touch "$folder/complete"
