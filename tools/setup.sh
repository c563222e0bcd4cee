#!/usr/bin/env bash
# Builds .venv from uv.lock and checks that it renders without a screen. `make setup` runs it.
#   PYTHON  the interpreter to build on (default: the first of python3, python3.11 ... that is new enough)
#   UV      the uv to use (default: the one on PATH, else one installed into .venv-uv)
set -euo pipefail
cd "$(dirname "$0")/.."

say() { printf '%s\n' "$*" >&2; }
stop() { say "setup: $*"; exit 1; }
can_apt() { [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; }
apt_install() {
    say "setup: installing $* with apt-get"
    apt-get update -qq >&2 && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq "$@" >&2
}
new_enough() { "$1" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; }

# The interpreter.
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

# uv: it reads the lock file, and can override the version that pyrender pins.
make_venv() {
    "$python" -m venv --clear "$1" >/dev/null 2>&1 && return
    can_apt && apt_install "python$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])')-venv" &&
        "$python" -m venv --clear "$1" && return
    stop "this Python makes no virtual environments; install its venv module (Debian, Ubuntu: apt-get install python3-venv)"
}
uv=${UV:-$(command -v uv || true)}
if [ -z "$uv" ]; then
    uv=.venv-uv/bin/uv
    if ! "$uv" --version >/dev/null 2>&1; then
        make_venv .venv-uv
        .venv-uv/bin/python -m pip install --quiet uv ||
            stop "could not install uv; install it yourself (https://docs.astral.sh/uv/) and run make setup again"
    fi
fi

# The environment, exactly as locked. The project itself is built anew each time: building makes the
# links in src/servosight/, which may be gone although nothing else has changed.
export UV_PROJECT_ENVIRONMENT=.venv UV_LINK_MODE=${UV_LINK_MODE:-copy}
unset VIRTUAL_ENV
if ! "$uv" sync --frozen --quiet --python "$python" --reinstall-package servosight; then
    # uv fetches from the addresses in the lock. Where only a mirror can be reached, pip knows it:
    # the same versions, held to the same hashes, from the index that pip is configured for.
    say "setup: uv sync did not succeed; trying pip with the same versions and hashes"
    make_venv .venv
    "$uv" export --frozen --quiet --no-emit-project --format requirements-txt --output-file .venv/requirements.txt
    .venv/bin/python -m pip install --quiet --no-deps --require-hashes -r .venv/requirements.txt
    .venv/bin/python -m pip install --quiet --no-deps --no-build-isolation --editable .
fi

# Rendering without a screen.
if ! .venv/bin/python tools/check_opengl.py; then
    if can_apt && apt_install libegl1 libgl1-mesa-dri && .venv/bin/python tools/check_opengl.py; then
        :
    else
        stop "no OpenGL without a screen: install EGL and Mesa's drivers (Debian, Ubuntu: apt-get install libegl1 libgl1-mesa-dri)"
    fi
fi

# Compile the numerical kernels into their cache, so that the first command does not wait for it.
if [ -f models/warmup.py ]; then
    .venv/bin/python -m servosight.models.warmup
fi
