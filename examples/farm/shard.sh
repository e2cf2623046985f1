#!/bin/sh
# Makes one part of a film or of a baked world, as one task of many. Slurm or Kubernetes says which part, and how many there are.
#   shard.sh          renders a part of the frames of DEMO, at SIZE, to OUT. It leaves out frames that a task of the same RUN has finished;
#                     under Slurm, RUN is the job
#   shard.sh bake     bakes a part of the shards of WORLD, from MIN to MAX, to OUT
set -eu
if [ -n "${SLURM_ARRAY_TASK_ID:-}" ]; then
    part=$((SLURM_ARRAY_TASK_ID - SLURM_ARRAY_TASK_MIN + 1))
    parts=$SLURM_ARRAY_TASK_COUNT
    # A task that is requeued keeps the number of its job, and goes on where it was killed. Another job makes every frame.
    run=${RUN:-${SLURM_ARRAY_JOB_ID:-}}
elif [ -n "${JOB_COMPLETION_INDEX:-}" ]; then
    part=$((JOB_COMPLETION_INDEX + 1))
    parts=${PARTS:?PARTS is the number of completions of the job}
    run=${RUN:-}
else
    echo "neither SLURM_ARRAY_TASK_ID nor JOB_COMPLETION_INDEX is set: this is no task of an array or an indexed job" >&2
    exit 2
fi
case ${1:-film} in
    film)
        out=${OUT:-frames}
        exec "${RAXEL:-raxel}" render "${DEMO:-worlds/valley.demo.toml}" --size "${SIZE:-1920x1080}" \
            ${FRAMES:+--frames "$FRAMES"} --shard "$part/$parts" -o "$out/%05d.png" ${run:+--resume "$out/.finished-$run-$part"}
        ;;
    bake)
        exec "${RAXEL:-raxel}" world bake "${WORLD:-worlds/frontier.toml}" ${MIN:+--min "$MIN"} ${MAX:+--max "$MAX"} \
            ${EDGE:+--edge "$EDGE"} ${LEVELS:+--levels "$LEVELS"} --shard "$part/$parts" --out "${OUT:-bakes/frontier}"
        ;;
    *)
        echo "\`$1\` is neither \`film\` nor \`bake\`" >&2
        exit 2
        ;;
esac
