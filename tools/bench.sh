#!/bin/sh
# Render, reconstruct and evaluate a survey once for each seed: tools/bench.sh SPEC.toml OUT/ SEED...
set -eu
spec=$1
out=$2
shift 2
python=.venv/bin/python

for seed in "$@"; do
    folder=$out/seed-$seed
    mkdir -p "$folder"
    sed "s/^seed = .*/seed = $seed/" "$spec" >"$folder/spec.toml"
    "$python" -m synth render "$folder/spec.toml" "$folder/survey"
    "$python" -m pipeline run "$folder/survey/survey.toml" --out "$folder/run" --truth "$folder/survey/truth.json"
    "$python" -m pipeline evaluate "$folder/run" --truth "$folder/survey/truth.json" \
        --json "$folder/evaluation.json" >"$folder/evaluation.txt"
done

echo
for seed in "$@"; do
    printf 'seed %-4s %s\n' "$seed" "$(grep '^MAE' "$out/seed-$seed/evaluation.txt")"
done
