#!/bin/bash
# 500 eigenpairs of the Laplacian of a mesh, which every rank reads.
#SBATCH --job-name=spectrum
#SBATCH --nodes=4
#SBATCH --ntasks-per-node=2
#SBATCH --cpus-per-task=16
#SBATCH --time=02:00:00
srun --mpi=pmix --cpus-per-task="$SLURM_CPUS_PER_TASK" --cpu-bind=cores \
    catamaran spectrum MESH.obj -k 500 -o E.npz
