#!/bin/sh -e
# A bag with names and topics of its own: motor and link in two topics, both called axis_1.
here=$(dirname "$0")
out=${1:-out/04}
hda import "$here/logs/joint_log.csv.gz" --map "$here/maps/joint_log.yaml" --out "$out/ours"
python3 "$here/others.py" "$out/ours" "$out/theirs"

names="--link-topic /robot/load --motor-topic /robot/drive"
hda info "$out/theirs" $names --name 'axis_*=joint*'
hda diagnose "$out/theirs" $names --name 'axis_*=joint*' --arm paper_single_axis.yaml \
  --out "$out/report"
