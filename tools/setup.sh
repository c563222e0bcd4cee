#!/usr/bin/env bash
# Builds .venv from uv.lock and checks that it renders without a screen. `make setup` runs it.
#   PYTHON  the interpreter to build on (default: the first of python3, python3.11 ... that is new enough)
#   UV      the uv to use (default: the one on PATH, else one installed into .venv-uv)
set -euo pipefail
cd "$(dirname "$0")/.."

say() { printf 'setup: %s\n' "$*" >&2; }
stop() { say "$*"; exit 1; }
new_enough() { "$1" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; }

say "1/4 checking Python and the system's libraries"
python=${PYTHON:-}
if [ -z "$python" ]; then
    for candidate in python3 python3.11 python3.12 python3.13 python3.14; do
        if command -v "$candidate" >/dev/null && new_enough "$candidate"; then
            python=$candidate
            break
        fi
    done
fi
[ -n "$python" ] && new_enough "$python" ||
    stop "servosight needs Python 3.11 or newer; install one and name it: make setup PYTHON=/path/to/python3.11"
python=$("$python" -c 'import sys; print(sys.executable)')

# Everything that the system lacks, before the long steps: one command installs it.
uv=${UV:-$(command -v uv || true)}
lacking() {
    if [ -z "$uv" ] && ! "$python" -c 'import ensurepip, venv' 2>/dev/null; then
        "$python" -c 'import sys; print("python%d.%d-venv" % sys.version_info[:2])'
    fi
    "$python" tools/check_opengl.py --libraries || true
}
packages=$(lacking | tr '\n' ' ')
packages=${packages% }
if [ -n "$packages" ]; then
    if ! command -v apt-get >/dev/null; then
        stop "install what is missing with your system's package manager (the packages are called $packages on Debian and Ubuntu), then repeat the command"
    elif [ "$(id -u)" != 0 ]; then
        stop "run this, then repeat the command: sudo apt-get update && sudo apt-get install -y $packages"
    fi
    say "installing $packages with apt-get (about a minute)"
    log=$(mktemp)
    # shellcheck disable=SC2086  # one word a package
    { apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq $packages; } >"$log" 2>&1 ||
        { tail -n 20 "$log" >&2; stop "apt-get could not install $packages (its last lines are above, all of them in $log)"; }
    rm -f "$log"
    packages=$(lacking | tr '\n' ' ')
    [ -z "$packages" ] || stop "still missing after apt-get install: $packages"
fi

# uv reads the lock file, and can override the version that pyrender pins.
if [ -z "$uv" ]; then
    uv=.venv-uv/bin/uv
    if ! "$uv" --version >/dev/null 2>&1; then
        say "2/4 installing uv into .venv-uv (20 MB, some seconds)"
        "$python" -m venv --clear .venv-uv
        .venv-uv/bin/python -m pip install --quiet uv ||
            stop "could not install uv; install it yourself (https://docs.astral.sh/uv/) and repeat the command"
    fi
fi

# The environment, exactly as locked. The project itself is built anew each time: building makes the
# links in src/servosight/, which may be missing although nothing else has changed.
say "3/4 installing the locked packages into .venv (1 GB on disk; one to five minutes the first time)"
export UV_PROJECT_ENVIRONMENT=.venv UV_LINK_MODE=${UV_LINK_MODE:-copy}
unset VIRTUAL_ENV
quiet=--quiet
[ ! -t 2 ] || quiet= # a terminal gets uv's progress bars
if ! "$uv" sync --frozen --compile-bytecode $quiet --python "$python" --reinstall-package servosight; then
    # uv fetches from the addresses in the lock. Where only a mirror can be reached, pip knows it:
    # the same versions, checked against the same hashes, from the index that pip is configured for.
    say "uv sync did not succeed; trying pip with the same versions and hashes (up to ten minutes)"
    "$python" -m venv --clear .venv
    "$uv" export --frozen --quiet --no-emit-project --format requirements-txt --output-file .venv/requirements.txt
    .venv/bin/python -m pip install --quiet --no-deps --require-hashes -r .venv/requirements.txt
    .venv/bin/python -m pip install --quiet --no-deps --no-build-isolation --editable .
fi

say "4/4 rendering a test picture and compiling the numerical kernels (about a minute the first time)"
.venv/bin/python tools/check_opengl.py ||
    stop "the libraries are there, but OpenGL does not render without a screen (the line above says why)"
.venv/bin/python -m servosight.models.plant.warmup
say "done"
