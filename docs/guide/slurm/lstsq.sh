#!/bin/bash
# Least squares of A.npy and B.npy. Ten minutes before the time limit the ranks save their sums, and
# the job is queued again.
#SBATCH --job-name=lstsq
#SBATCH --nodes=4
#SBATCH --ntasks-per-node=2
#SBATCH --cpus-per-task=16
#SBATCH --time=08:00:00
#SBATCH --signal=USR1@600
#SBATCH --requeue
#SBATCH --open-mode=append
status=0
srun --mpi=pmix --cpus-per-task="$SLURM_CPUS_PER_TASK" --cpu-bind=cores \
    catamaran lstsq A.npy B.npy -o X.npz --intercept \
    --checkpoint sums-lstsq --resume || status=$?
# 138: ended by SIGUSR1.
if [ "$status" -eq 138 ]; then scontrol requeue "$SLURM_JOB_ID"; fi
exit "$status"
