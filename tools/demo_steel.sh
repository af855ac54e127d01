#!/bin/sh
# Scan a structure, measure it, compare it with its truth, say what to open: tools/demo_steel.sh SPEC.toml OUT/
set -eu
spec=$1
out=$2
python=.venv/bin/python

"$python" -m synth scan "$spec" "$out/survey"
"$python" -m pipeline steel "$out/survey/survey.toml" --out "$out/run" --truth "$out/survey/truth.json"
echo
"$python" -m pipeline evaluate "$out/run" --truth "$out/survey/truth.json" --json "$out/evaluation.json"
echo
echo "Open"
echo "  model   $out/run/members.glb"
echo "  report  $out/run/report.html"
