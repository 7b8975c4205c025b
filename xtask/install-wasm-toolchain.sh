#!/usr/bin/env bash
# Makes a Rust toolchain that can build for wasm32-unknown-unknown where rustup cannot add the target, from Debian's
# packages rustc-web and rust-web-src, and prints the path of a cargo that uses it. `cargo xtask plugins` calls it.
#
# Nothing is installed: the packages are unpacked under $VB_WASM_HOME (default: ~/.local/share/vb-wasm) and the
# standard library is built there once, since it must come from the compiler's own sources. Takes about a minute and
# 550 MB. Neither the system nor ~/.rustup is touched.
set -euo pipefail
target=wasm32-unknown-unknown
tools=${VB_WASM_HOME:-${XDG_DATA_HOME:-$HOME/.local/share}/vb-wasm}/toolchain
say() { echo "install-wasm-toolchain: $*" >&2; }
fail() { say "$*"; exit 1; }

library=$tools/lib/rustlib/$target/lib
if ls "$library"/libstd-*.rlib >/dev/null 2>&1; then
    echo "$tools/cargo-wasm"
    exit 0
fi
command -v apt-get >/dev/null && command -v dpkg >/dev/null ||
    fail "there is no apt-get here; run 'rustup target add $target' instead"
[ "$(uname -m)" = x86_64 ] || fail "this works on x86-64 only; run 'rustup target add $target' instead"

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

if ! [ -x "$tools/bin/rustc" ]; then
    say "unpacking Debian's Rust compiler into $tools"
    apt-get update -qq >&2 || say "the package lists could not be updated; going on with those that are there"
    version=$(apt-cache policy rustc-web | awk '/Candidate:/ {print $2}')
    [ -n "$version" ] && [ "$version" != "(none)" ] || fail "the package rustc-web is not available here"
    upstream=${version%%+*}
    series=${upstream%.*}
    llvm=$(apt-cache show "libstd-rust-web-$series" | grep -o 'libllvm[0-9]*' | head -1)
    (cd "$scratch" && apt-get download -qq "rustc-web=$version" "rust-web-src=$version" \
        "libstd-rust-web-dev=$version" "libstd-rust-web-$series=$version" "$llvm" >&2) ||
        fail "the packages of rustc-web $version could not be fetched"
    for package in "$scratch"/*.deb; do dpkg -x "$package" "$scratch/x"; done

    new=$tools.new
    rm -rf "$new"
    host=x86_64-unknown-linux-gnu
    mkdir -p "$new/bin" "$new/lib/rustlib/src/rust"
    mv "$scratch/x/usr/bin/rustc" "$new/bin/"
    mv "$scratch"/x/usr/lib/x86_64-linux-gnu/lib*.so* "$new/lib/"
    mv "$scratch/x/usr/lib/rustlib/$host" "$new/lib/rustlib/"
    mv "$scratch/x/usr/src/rustc-$upstream/library" "$new/lib/rustlib/src/rust/"
    # The linker of the installed toolchain serves any rustc. It finds its own libraries relative to itself, hence
    # a wrapper and not a link.
    mkdir -p "$new/lib/rustlib/$host/bin"
    linker=$(rustc --print sysroot)/lib/rustlib/$host/bin/rust-lld
    [ -x "$linker" ] || fail "$linker is missing; install a full Rust toolchain by rustup"
    printf '#!/bin/sh\nexec "%s" "$@"\n' "$linker" >"$new/lib/rustlib/$host/bin/rust-lld"
    cat >"$new/rustc-wasm" <<WRAPPER
#!/bin/sh
LD_LIBRARY_PATH="$tools/lib\${LD_LIBRARY_PATH:+:\$LD_LIBRARY_PATH}" exec "$tools/bin/rustc" "\$@"
WRAPPER
    cat >"$new/cargo-wasm" <<WRAPPER
#!/bin/sh
export RUSTC="$tools/rustc-wasm"
unset RUSTUP_TOOLCHAIN
exec "$(rustup which cargo 2>/dev/null || command -v cargo)" "\$@"
WRAPPER
    chmod +x "$new/rustc-wasm" "$new/cargo-wasm" "$new/lib/rustlib/$host/bin/rust-lld"
    rm -rf "$tools"
    mkdir -p "$(dirname "$tools")"
    mv "$new" "$tools"
fi

say "building the standard library for $target"
mkdir -p "$scratch/std/src" "$scratch/std/.cargo"
echo '#![no_std]' >"$scratch/std/src/lib.rs"
cat >"$scratch/std/Cargo.toml" <<'MANIFEST'
[package]
name = "vbstd"
version = "0.0.0"
edition = "2021"
[profile.release]
panic = "abort"
[workspace]
MANIFEST
# The sources bring the crates that they need along.
cat >"$scratch/std/.cargo/config.toml" <<CONFIG
[source.crates-io]
replace-with = "vendored"
[source.vendored]
directory = "$tools/lib/rustlib/src/rust/library/vendor"
CONFIG
# Bitcode, since planners are linked with LTO; without paths of this machine, since they end up in panic messages.
(cd "$scratch/std" && env -u CARGO_TARGET_DIR -u CARGO_BUILD_TARGET -u CARGO_ENCODED_RUSTFLAGS RUSTC_BOOTSTRAP=1 \
    RUSTFLAGS="-Cembed-bitcode=yes --remap-path-prefix=$tools=/toolchain" \
    "$tools/cargo-wasm" build --quiet --release -Zbuild-std=std,panic_abort,proc_macro --target $target >&2) ||
    fail "the standard library could not be built"
mkdir -p "$library"
for file in "$scratch/std/target/$target/release/deps"/lib*.rlib; do
    case $file in */libvbstd-*) ;; *) cp "$file" "$library/" ;; esac
done
echo "$tools/cargo-wasm"
