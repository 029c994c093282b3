#!/bin/sh -e
# An arm file for a gear of the catalogue, and a recording of a worn arm with it.
here=$(dirname "$0")
out=${1:-out/06}
mkdir -p "$out"
hda new --gear CSG-17-100 --motor-inertia 5e-6 --motor-torque 0.3 --motor-counts 16384 \
  --link-counts 4e6 --lengths 0.15 0.15 --masses 2 1.5 --out "$out/arm.yaml"
hda simulate --arm "$out/arm.yaml" --effects "$here/effects/worn_joint.yaml" --motion rich \
  --duration 10 --out "$out/bag"
hda estimate "$out/bag" --arm "$out/arm.yaml" --out "$out/estimates"
hda export "$out/estimates" --topic joint_torques --out "$out/torques.csv"
