#!/bin/sh
# Render a survey, reconstruct it, compare it with its truth, and say what to open: tools/demo.sh SPEC.toml OUT/
set -eu
spec=$1
out=$2
python=.venv/bin/python

began=$(date +%s)
"$python" -m synth render "$spec" "$out/survey"
rendered=$(date +%s)
"$python" -m pipeline run "$out/survey/survey.toml" --out "$out/run" --truth "$out/survey/truth.json"
reconstructed=$(date +%s)
"$python" -m pipeline evaluate "$out/run" --truth "$out/survey/truth.json" --json "$out/evaluation.json"

# both steps go on from what is already there: only the first time shows what they cost
echo
echo "Time"
printf '  %-12s %5d s\n' render $((rendered - began)) reconstruct $((reconstructed - rendered))
echo
echo "Open"
echo "  model   $out/run/model.glb"
echo "  report  $out/run/report.html"
