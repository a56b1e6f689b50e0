# SPDX-License-Identifier: MIT
# Sourced: `step NAME COMMAND...` runs a command with all its output in $log and one line of progress here. Counts are
# read from what ninja ("[12/80]"), ctest ("12/54 Test") and apt-get ("Unpacking", of `scripts/setup`) print.
log=$PWD/build/${0##*/}.log
mkdir -p build
: >"$log"

minutes() { printf '%d:%02d' $(($1 / 60)) $(($1 % 60)); }

# Reads a command's output; on a terminal the line moves, elsewhere there is one every half a minute.
show_progress() {
  local name=$1 begin=$SECONDS shown=-30 count=0 of=0 line text
  while IFS= read -r line; do
    if [[ $line =~ ^\[([0-9]+)/([0-9]+)\] || $line =~ ^\ *([0-9]+)/([0-9]+)\ Test ]]; then
      count=${BASH_REMATCH[1]} of=${BASH_REMATCH[2]}
    elif [[ $line =~ ^([0-9]+)\ upgraded,\ ([0-9]+)\ newly ]]; then
      count=0 of=$((2 * BASH_REMATCH[2]))
    elif [[ $line =~ ^(Unpacking|Setting\ up)\  ]] && ((count < of)); then
      count=$((count + 1))
    else
      continue
    fi
    local elapsed=$((SECONDS - begin)) every=30
    [ ! -t 1 ] || every=0
    ((SECONDS - shown >= every)) || continue
    shown=$SECONDS
    text="== $name: $count of $of, $(minutes $elapsed)"
    ((count == 0 || count == of || elapsed < 5)) || text+=", some $(minutes $((elapsed * (of - count) / count))) left"
    if [ -t 1 ]; then printf '\r\e[K%s' "$text"; else echo "$text"; fi
  done
  [ ! -t 1 ] || printf '\r\e[K'
  echo "== $name: $(minutes $((SECONDS - begin)))"
}

step() {
  local name=$1 code
  shift
  printf '== %s\n' "$name" >>"$log"
  [ ! -t 1 ] || printf '== %s' "$name"
  "$@" 2>&1 | tee -a "$log" | show_progress "$name"
  code=${PIPESTATUS[0]}
  ((code == 0)) || { tail -n 20 "$log" >&2; echo "$name failed; $log has all of it" >&2; }
  return "$code"
}
