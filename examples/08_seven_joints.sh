#!/bin/sh -e
# Seven joints from a robot description: pushed at the tip, torques and the wrench estimated.
# Then pushed at the elbow: the joint that the contact lies beyond is named.
out=${1:-out/08}
mkdir -p "$out"
hda simulate --arm cobot7.yaml --motion push --duration 6 --seed 5 --out "$out/bag"
hda estimate "$out/bag" --arm cobot7.yaml --out "$out/estimates" --page "$out/estimates.html"
hda export "$out/estimates" --topic tip/wrench --out "$out/wrench.csv"

hda simulate --arm cobot7.yaml --motion push --push-at joint3 --duration 6 --out "$out/elbow"
hda estimate "$out/elbow" --arm cobot7.yaml --out "$out/elbow_estimates" --json > "$out/elbow.json"
