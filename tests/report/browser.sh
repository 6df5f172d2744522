#!/usr/bin/env bash
# Makes .test-env/browser/run, a headless Chromium for the tests of report.html: one that is on the PATH, or else Debian's
# chromium-headless-shell, unpacked there with the libraries that this machine lacks. Nothing is installed. Where neither can
# be had it says so; the tests then skip what needs a browser.
set -euo pipefail
cd "$(dirname "$0")/../.."

folder=$PWD/.test-env/browser
run=$folder/run

say() { echo "browser: $*" >&2; }
works() { "$run" --version >/dev/null 2>&1; }

# The browser that is there already.
on_path() {
  local name
  for name in chromium chromium-headless-shell google-chrome chromium-browser; do
    command -v "$name" >/dev/null || continue
    printf '#!/bin/sh\nexec %s "$@"\n' "$name" >"$run"
    chmod +x "$run"
    works && return
  done
  return 1
}

# Packages of Debian, downloaded and unpacked. The lists of packages are our own: those of the machine may be missing or old.
from_packages() {
  command -v apt-get >/dev/null && command -v dpkg-deb >/dev/null || return 1
  mkdir -p "$folder"/{lists,archives}/partial "$folder/root"
  local apt=(apt-get -q -y -o Dir::State::lists="$folder/lists" -o Dir::Cache::archives="$folder/archives"
    -o Dir::Cache::pkgcache= -o Dir::Cache::srcpkgcache= -o Debug::NoLocking=1 -o APT::Sandbox::User=)
  "${apt[@]}" update >"$folder/log" 2>&1 || say "some lists of packages cannot be read"
  "${apt[@]}" --no-install-recommends --download-only install chromium-headless-shell fonts-dejavu-core >>"$folder/log" 2>&1 ||
    return 1
  local package
  for package in "$folder"/archives/*.deb; do
    dpkg-deb -x "$package" "$folder/root"
  done
  rm -rf "$folder"/{lists,archives}
  cat >"$folder/fonts.conf" <<END
<?xml version="1.0"?>
<fontconfig>
  <dir>/usr/share/fonts</dir>
  <dir>$folder/root/usr/share/fonts</dir>
  <cachedir>$folder/fonts</cachedir>
  <match target="pattern"><edit name="family" mode="append_last"><string>DejaVu Sans</string></edit></match>
</fontconfig>
END
  # every folder with libraries: some packages have one of their own
  local libraries
  libraries=$(find "$folder/root" -name '*.so*' -printf '%h\n' | sort -u | paste -sd:)
  cat >"$run" <<END
#!/bin/sh
export LD_LIBRARY_PATH='$libraries' FONTCONFIG_FILE='$folder/fonts.conf'
exec '$folder/root/usr/lib/chromium/chromium-headless-shell' "\$@"
END
  chmod +x "$run"
  works
}

if works; then
  say "ready"
  exit
fi
rm -rf "$folder"
mkdir -p "$folder"
if on_path || from_packages; then
  say "$("$run" --version 2>/dev/null)"
else
  [ ! -f "$folder/log" ] || tail -n 5 "$folder/log" >&2
  rm -f "$run"
  say "no Chromium on the PATH and none among the packages of this system: its tests will be skipped"
fi
