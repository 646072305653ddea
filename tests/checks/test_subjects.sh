#!/bin/sh
# Subjects of commits have two words at least and 72 characters at most. Commits up to FIRST are older than the rule.
#   test_subjects.sh SOURCE_FOLDER FIRST
# Exit code 77: nothing to check, as in a copy without git's history.
set -eu
cd "$1"
first=$2
if ! git rev-parse --is-inside-work-tree >/dev/null 2>&1 || ! git cat-file -e "$first^{commit}" 2>/dev/null; then
  echo "skipped: no git history back to $first"
  exit 77
fi
long=$(git log --no-merges --format='%h %s' "$first..HEAD" | awk '{ if (length($0) - length($1) - 1 > 72 || NF < 3) print }')
[ -z "$long" ] || { echo "subjects of one word or of more than 72 characters:"; echo "$long"; exit 1; }
echo "$(git rev-list --no-merges --count "$first..HEAD") subjects, all of them fit"
