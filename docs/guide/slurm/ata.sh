#!/bin/bash
# A^T A of A.npy. Ten minutes before the time limit the ranks save their sums, and
# the job is queued again.
#SBATCH --job-name=ata
#SBATCH --nodes=4
#SBATCH --ntasks-per-node=2
#SBATCH --cpus-per-task=16
#SBATCH --time=08:00:00
#SBATCH --signal=USR1@600
#SBATCH --requeue
#SBATCH --open-mode=append
status=0
srun --mpi=pmix --cpus-per-task="$SLURM_CPUS_PER_TASK" --cpu-bind=cores \
    catamaran ata A.npy -o C.npy --reproducible \
    --checkpoint sums-ata --resume || status=$?
# 138: ended by SIGUSR1.
if [ "$status" -eq 138 ]; then scontrol requeue "$SLURM_JOB_ID"; fi
exit "$status"
