#!/bin/sh -e
# One figure of the paper with its numbers beside the printed ones: out/07/paper.html
hda reproduce fig7 --out "${1:-out/07}"
