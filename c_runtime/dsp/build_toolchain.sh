#!/bin/sh
# SPDX-License-Identifier: MIT
# Build a C6000 cross compiler (tic6x-elf, C only, no libraries) once, from the source packages of
# Debian or Ubuntu, into a folder that is kept. Takes six minutes on two cores, 60 MB when done.
#
#   build_toolchain.sh FOLDER      FOLDER/bin/tic6x-elf-gcc afterwards; on failure FOLDER is as before
#   build_toolchain.sh --missing   what to install first, status 1; nothing and 0 where all is there
set -eu

prefix=${1:?usage: build_toolchain.sh FOLDER}
packages="gcc-12-source binutils-source build-essential flex bison libgmp-dev libmpfr-dev libmpc-dev xz-utils"
binutils=$(ls /usr/src/binutils/binutils-*.tar.xz 2>/dev/null | head -n 1)
compiler=$(ls /usr/src/gcc-12/gcc-12*.tar.xz 2>/dev/null | head -n 1)

everything_is_here() {
    [ -n "$binutils" ] && [ -n "$compiler" ] || return 1
    for tool in gcc g++ make flex bison tar xz; do
        command -v "$tool" > /dev/null || return 1
    done
    printf '#include <stdio.h>\n#include <gmp.h>\n#include <mpfr.h>\n#include <mpc.h>\n' |
        gcc -fsyntax-only -x c - 2> /dev/null
}

if [ "$prefix" = "--missing" ]; then
    everything_is_here && exit 0
    echo "apt-get install $packages"
    exit 1
fi
case $prefix in
    /*) ;;
    *) prefix=$PWD/$prefix ;;
esac
if [ -x "$prefix/bin/tic6x-elf-gcc" ]; then
    echo "$prefix/bin/tic6x-elf-gcc is there already"
    exit 0
fi
if ! everything_is_here; then
    echo "the C6000 compiler is built from source packages: apt-get install $packages" >&2
    exit 1
fi

# In a folder of its own beside the result, and moved there at the end: what is half done is never
# taken for it, two that build at once do not meet, and nothing but the log outlives a failure.
work="$prefix.building.$$"
log="$prefix.log"
trap 'rm -rf "$work"' EXIT
trap 'exit 1' HUP INT TERM
mkdir -p "$work/binutils" "$work/gcc"
: > "$log"
jobs=$(nproc)
# Release checking and -O1: the compiler is run on a dozen small files.
flags="CFLAGS=-O1 CXXFLAGS=-O1 MAKEINFO=true"

step() {
    echo "$1"
    shift
    "$@" >> "$log" 2>&1 || { tail -n 20 "$log" >&2; echo "failed; all of it is in $log" >&2; exit 1; }
}

step "unpacking binutils" tar -C "$work/binutils" --strip-components=1 -xf "$binutils"
mkdir "$work/binutils/build"
cd "$work/binutils/build"
step "configuring binutils" ../configure --target=tic6x-elf --prefix="$prefix" --disable-nls \
    --disable-werror --disable-gdb --disable-sim --disable-gprofng --disable-multilib
step "building binutils" make -j "$jobs" $flags all-binutils all-gas all-ld
step "installing binutils" make $flags DESTDIR="$work/root" install-binutils install-gas install-ld

step "unpacking gcc" tar -C "$work/gcc" --strip-components=1 -xf "$compiler"
mkdir "$work/gcc/build"
cd "$work/gcc/build"
PATH="$work/root$prefix/bin:$PATH"
export PATH
step "configuring gcc" ../configure --target=tic6x-elf --prefix="$prefix" --enable-languages=c \
    --without-headers --with-newlib --disable-nls --disable-shared --disable-threads \
    --disable-multilib --disable-libssp --disable-lto --disable-plugin --disable-bootstrap \
    --enable-checking=release
step "building gcc" make -j "$jobs" $flags all-gcc
# Not install-gcc: Debian's tarball is without the manuals that it wants to make.
step "installing gcc" make -C gcc $flags DESTDIR="$work/root" \
    install-common install-driver install-headers

if [ ! -x "$prefix/bin/tic6x-elf-gcc" ]; then
    rm -rf "$prefix"
    mv "$work/root$prefix" "$prefix"
fi
rm -f "$log"
"$prefix/bin/tic6x-elf-gcc" --version | head -n 1
