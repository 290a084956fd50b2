//! A script that submits a Slurm array job, and one that depends on it.

use super::{FarmJob, Work, line, text};
use reflet_frame::resume::ranges;

/// The script. Its own arguments go to `sbatch`.
pub fn script(job: &FarmJob) -> String {
    let name = job.script.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let name: String = name
        .unwrap_or_default()
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() || c == '-' || c == '_' { c } else { '-' })
        .collect();
    let (tasks, command) = match &job.work {
        Work::Frames { frames, chunk, .. } => {
            let tasks = frames.len().div_ceil(*chunk);
            let mut words = job.render(&text(&job.output));
            words.extend(["--frames".into(), ranges(frames)]);
            (tasks, format!("{} --shard \"$SLURM_ARRAY_TASK_ID/{tasks}\"", line(&words)))
        }
        Work::Tiles { tiles, frame } => {
            let (columns, rows) = (tiles.columns, tiles.rows);
            let mut words = job.render("PART");
            words.extend(["--frames".into(), frame.to_string()]);
            let part = format!("{}/\"$column-$row.exr\"", super::quoted(&job.parts()));
            let command = line(&words).replacen("-o PART", &format!("-o {part}"), 1);
            let place = format!(
                "column=$(( (SLURM_ARRAY_TASK_ID - 1) % {columns} + 1 ))\n\
                 row=$(( (SLURM_ARRAY_TASK_ID - 1) / {columns} + 1 ))\n"
            );
            let tile = format!("--tile \"$column,$row/{columns}x{rows}\"");
            ((columns * rows) as usize, format!("{place}@{command} {tile}"))
        }
    };
    let (place, command) = match command.split_once('@') {
        Some((place, command)) if place.starts_with("column=") => (place, command),
        _ => ("", command.as_str()),
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
