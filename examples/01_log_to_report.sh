#!/bin/sh -e
# From the log of a drive (counts, degrees, amperes) to a report: out/01/report/report.html
here=$(dirname "$0")
out=${1:-out/01}

# Where a table is new, `hda import TABLE --guess` writes most of such a map.
hda import "$here/logs/joint_log.csv.gz" --map "$here/maps/joint_log.yaml" --out "$out/bag"
hda info "$out/bag"
hda diagnose "$out/bag" --arm paper_single_axis.yaml --out "$out/report"
