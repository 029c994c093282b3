#!/bin/sh -e
# Two devices, a folder each. The second call finds nothing new; the third one raises an alarm (3).
here=$(dirname "$0")
out=${1:-out/05}
hda import "$here/logs/joint_log.csv.gz" --map "$here/maps/joint_log.yaml" --out "$out/bags/worn/run1"
hda simulate --arm paper_single_axis.yaml --motion rich --duration 10 --out "$out/bags/new/run1"

hda diagnose --each "$out/bags" --arm paper_single_axis.yaml --update --out "$out/fleet"
hda diagnose --each "$out/bags" --arm paper_single_axis.yaml --update --out "$out/fleet"
hda diagnose --each "$out/bags" --arm paper_single_axis.yaml --update --out "$out/fleet" --alarm \
  || test $? = 3
