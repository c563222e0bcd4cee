#!/usr/bin/env bash
# Repeats the promise of two commands on a bare Debian or Ubuntu: `make demo` and `make test` in a root
# that debootstrap makes with git, make, python3, python3-venv and ca-certificates and nothing else.
# `make bare` runs it. As root on Debian or Ubuntu with debootstrap; 4 GB on disk, about 25 minutes.
#   PLACE    where the root is made (default /var/tmp/servosight-bare); its base is kept for the next run
#   SUITE    bookworm, trixie, noble, ... (default bookworm)
#   MIRROR   where its packages are (default http://deb.debian.org/debian)
#   TARGETS  what make builds there (default: demo test)
# What is committed is tested. This machine's own settings for apt, pip, uv, certificates and names are
# copied into the root, so that it fetches packages as this machine does.
set -euo pipefail
cd "$(dirname "$0")/.."
project=$PWD
PLACE=${PLACE:-/var/tmp/servosight-bare} SUITE=${SUITE:-bookworm}
MIRROR=${MIRROR:-http://deb.debian.org/debian} TARGETS=${TARGETS:-demo test}
root=$PLACE/$SUITE

say() { printf 'bare root: %s\n' "$*" >&2; }
stop() { say "$*"; exit 1; }
[ "$(id -u)" = 0 ] || stop "run this as root: it makes a root of its own and enters it"
command -v debootstrap >/dev/null || stop "debootstrap is missing: apt-get install debootstrap"

mkdir -p "$PLACE"
if [ ! -e "$PLACE/$SUITE.tar" ]; then
    say "making $SUITE with debootstrap (about four minutes; kept in $PLACE/$SUITE.tar)"
    rm -rf "$PLACE/base"
    debootstrap --variant=minbase --include=git,make,python3,python3-venv,ca-certificates \
        "$SUITE" "$PLACE/base" "$MIRROR" >"$PLACE/debootstrap.log" 2>&1 ||
        stop "debootstrap failed, see $PLACE/debootstrap.log"
    tar -C "$PLACE/base" -cf "$PLACE/$SUITE.tar.part" .
    mv "$PLACE/$SUITE.tar.part" "$PLACE/$SUITE.tar"
    rm -rf "$PLACE/base"
fi
say "unpacking $root"
rm -rf "$root"
mkdir "$root"
tar -C "$root" -xf "$PLACE/$SUITE.tar"

# How this machine reaches its package indexes.
for file in /etc/resolv.conf /etc/hosts /etc/pip.conf /etc/uv/uv.toml /etc/ssl/certs/ca-certificates.crt \
    /etc/apt/apt.conf.d/*proxy* /etc/apt/apt.conf.d/99*; do
    [ ! -e "$file" ] || { mkdir -p "$root$(dirname "$file")" && cp -L "$file" "$root$file"; }
done
carried=(HOME=/root PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin)
while IFS= read -r -d '' setting; do
    case $setting in
        PIP_* | UV_INDEX* | UV_DEFAULT_INDEX=* | SSL_CERT_* | [Hh][Tt][Tt][Pp]*_[Pp][Rr][Oo][Xx][Yy]=* | [Nn][Oo]_[Pp][Rr][Oo][Xx][Yy]=*)
            carried+=("$setting")
            ;;
    esac
done </proc/self/environ

git clone --quiet --no-hardlinks "$project" "$root/srv/servosight"

# inside USER COMMAND: its own mounts and processes end with it
inside() {
    unshare --mount --pid --fork -- bash -c \
        'mount -t proc proc "$1/proc" && mount --bind /dev/pts "$1/dev/pts" && exec chroot --userspec="$2" "$1" env -i "${@:4}" sh -c "cd /srv/servosight && $3"' \
        bash "$root" "$1" "$2" "${carried[@]}" </dev/null
}
timed() {
    local start=$SECONDS
    say "$*"
    "$@" || stop "failed after $((SECONDS - start)) s: $*"
    say "ended with 0 after $((SECONDS - start)) s: $*"
}

# Without root's rights, set-up stops at once and names the command that root has to run.
if inside nobody:nogroup "make setup" 2>"$PLACE/nobody.log"; then
    stop "set-up succeeded without the libraries: the root is not bare"
fi
grep -q "sudo apt-get update && sudo apt-get install -y .*libegl1.*libgl1" "$PLACE/nobody.log" ||
    { cat "$PLACE/nobody.log" >&2; stop "set-up without root's rights does not name the packages"; }

for target in $TARGETS; do
    timed inside root:root "make $target"
done
