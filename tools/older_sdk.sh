#!/usr/bin/env bash
# Runs the tests that Dynamixel's SDK takes part in once more, under version 3 of it.
# One environment holds one version: the other lies in a folder that comes first on Python's path.
set -euo pipefail
cd "$(dirname "$0")/.."

folder=.venv/dynamixel-sdk-3
if [ ! -d "$folder" ]; then
    fresh=$folder.new
    rm -rf "$fresh"
    uv=${UV:-$(command -v uv || echo .venv-uv/bin/uv)}
    # Where only a mirror can be reached, pip knows it (tools/setup.sh).
    "$uv" pip install --quiet --python .venv/bin/python --no-deps --require-hashes \
        --target "$fresh" --requirement tools/older_sdk.txt ||
        .venv-uv/bin/python -m pip install --quiet --no-deps --require-hashes \
            --target "$fresh" --requirement tools/older_sdk.txt
    mv "$fresh" "$folder"
fi
export PYTHONPATH=$folder SERVOSIGHT_DYNAMIXEL_SDK=3
exec .venv/bin/python -m pytest -q tests/bench/wire/test_second_opinion.py -k dynamixel "$@"
