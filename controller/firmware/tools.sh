#!/usr/bin/env bash
# Unpacks Debian's cross compiler and emulator into a folder, installing nothing: an installed qemu-utils of another version stays.
#
#     bash controller/firmware/tools.sh FOLDER
set -euo pipefail
mkdir -p "$1"
folder=$(realpath "$1")
[ -e "$folder/complete" ] && exit 0
packages=(gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm)
list() { apt-get install --simulate --no-install-recommends "${packages[@]}" 2>/dev/null | awk '/^Inst/ { print $2 }'; }
names=$(list) || { apt-get update >/dev/null && names=$(list); }
# What is installed already is not in the list, and need not be.
mkdir -p "$folder/packages" && cd "$folder/packages"
[ -z "$names" ] || apt-get download $names >/dev/null
for package in *.deb; do dpkg --extract "$package" "$folder"; done
touch "$folder/complete"
