//! A script that submits a Slurm array job, and one that depends on it.

use super::{CHUNK, FarmJob, Work, line, quoted};
use reflet_frame::resume::ranges;
use std::path::Path;

/// The most tasks of an array as Slurm is set up by itself: `MaxArraySize` is 1001, and indices are
/// below it.
const MOST_TASKS: usize = 1000;

/// How many tasks there are.
#[derive(Clone, Copy)]
pub struct Array(usize);

impl Array {
    /// The tasks of some work: at most [`MOST_TASKS`], unless their size was asked for.
    pub fn of(work: &Work) -> Array {
        match work {
            Work::Frames { frames, chunk, .. } => {
                let grown = || CHUNK.max(frames.len().div_ceil(MOST_TASKS));
                Array(frames.len().div_ceil(chunk.unwrap_or_else(grown)))
            }
            Work::Tiles { tiles, .. } => Array(tiles.columns as usize * tiles.rows as usize),
        }
    }

    /// What to tell if Slurm may refuse the array.
    pub fn warning(self) -> Option<String> {
        let Array(tasks) = self;
        (tasks > MOST_TASKS).then(|| {
            format!(
                "the array has {tasks} tasks; sbatch refuses it where slurm.conf leaves \
                 MaxArraySize at 1001, which allows {MOST_TASKS}: take a greater --chunk, or fewer \
                 --tiles"
            )
        })
    }
}

/// The script. Its own arguments go to `sbatch`.
pub fn script(job: &FarmJob, Array(tasks): Array) -> String {
    // A name in a comment of sbatch's: no quotes are read there.
    let name: String = Path::new(&job.script)
        .file_stem()
        .map(|stem| stem.to_string_lossy().into_owned())
        .unwrap_or_default()
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() || c == '-' || c == '_' { c } else { '-' })
        .collect();
    let (scene, options) = (line(&job.scene()), line(&job.options()));
    let (place, command) = match &job.work {
        Work::Frames { frames, .. } => {
            let (output, frames) = (quoted(&job.output), ranges(frames));
            let shard = format!("--shard \"$SLURM_ARRAY_TASK_ID/{tasks}\"");
            (String::new(), format!("{scene} {output} {options} --frames {frames} {shard}"))
        }
        Work::Tiles { tiles, frame } => {
            let (columns, rows) = (tiles.columns, tiles.rows);
            let part = format!("{}/\"$column-$row.exr\"", quoted(job.parts()));
            let place = format!(
                "column=$(( (SLURM_ARRAY_TASK_ID - 1) % {columns} + 1 ))\n\
                 row=$(( (SLURM_ARRAY_TASK_ID - 1) / {columns} + 1 ))\n"
            );
            let tile = format!("--tile \"$column,$row/{columns}x{rows}\"");
            (place, format!("{scene} {part} {options} --frames {frame} {tile}"))
        }
    };
    let mut script = format!(
        "#!/bin/sh\n\
         # Submits the job; what is given to this script goes to sbatch, as in --partition=night.\n\
         # A task that is warned (USR1) or interrupted ends with exit code 75 and goes on where it\n\
         # was: let slurm.conf say RequeueExit=75. REFLET names the program if it is not `reflet`.\n\
         set -eu\n\
         array=$(sbatch --parsable \"$@\" <<'JOB'\n\
         #!/bin/sh\n\
         #SBATCH --job-name={name}\n\
         #SBATCH --array=1-{tasks}\n\
         #SBATCH --requeue\n\
         #SBATCH --open-mode=append\n\
         #SBATCH --signal=B:USR1@30\n\
         {place}exec \"${{REFLET:-reflet}}\" {command}\n\
         JOB\n\
         )\n\
         echo \"$array\"\n"
    );
    if let Some(words) = job.ending() {
        let verify = match &job.work {
            Work::Frames { frames, .. } => {
                let words = line(&job.verify(frames));
                format!("set -e\n\"${{REFLET:-reflet}}\" {words}\n")
            }
            Work::Tiles { .. } => String::new(),
        };
        script += &format!(
            "# Not afterok: to that, a task that is queued again has failed. What is missing is noticed.\n\
             sbatch --parsable --dependency=\"afterany:${{array%%;*}}\" \"$@\" <<'JOB'\n\
             #!/bin/sh\n\
             #SBATCH --job-name={name}-{}\n\
             {}exec \"${{REFLET:-reflet}}\" {}\n\
             JOB\n",
            words[0],
            verify,
            line(&words)
        );
    }
    script
}
