#!/usr/bin/env bash
# Snakemake asks how a job is: running, success or failed. Without Slurm's accounting: scontrol knows it for MinJobAge.
state=$(scontrol show job "$1" 2>/dev/null | sed -n 's/.*JobState=\([A-Z_]*\).*/\1/p' | head -n 1)
case $state in
  COMPLETED) echo success ;;
  PENDING | CONFIGURING | RUNNING | COMPLETING | SUSPENDED | REQUEUED | STOPPED) echo running ;;
  *) echo failed ;;
esac
