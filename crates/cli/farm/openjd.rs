//! An Open Job Description template (2023-09, with the extension TASK_CHUNKING).

use super::{FarmJob, Work, text};
use crate::exit::{Exit, Failure};
use reflet_frame::resume::ranges;
use serde_json::{Value, json};
use std::path::Path;

/// The template, as JSON.
///
/// # Errors
/// Never for what a command line can say.
pub fn template(job: &FarmJob) -> Result<String, Failure> {
    let name = job.script.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let (scene_folder, scene) = folder_and_name(&job.script);
    let (out_folder, out) = folder_and_name(&job.output);
    let output = format!("{{{{Param.OutputFolder}}}}/{out}");
    let mut render: Vec<String> =
        vec!["render".into(), format!("{{{{Param.SceneFolder}}}}/{scene}"), "-o".into()];
    let mut parameters = vec![
        folder("SceneFolder", &scene_folder, "IN"),
        folder("OutputFolder", &out_folder, "OUT"),
        json!({ "name": "Reflet", "type": "STRING", "default": "reflet" }),
    ];
    let mut extensions: Vec<&str> = Vec::new();
    let (space, end) = match &job.work {
        Work::Frames { frames, chunk, film } => {
            extensions.push("TASK_CHUNKING");
            parameters.push(json!({
                "name": "Frames", "type": "STRING", "default": ranges(frames)
            }));
            render.push(output.clone());
            render.extend(["--frames".into(), "{{Task.Param.Frame}}".into()]);
            let space = json!({ "taskParameterDefinitions": [{
                "name": "Frame",
                "type": "CHUNK[INT]",
                "range": "{{Param.Frames}}",
                "chunks": { "defaultTaskCount": chunk, "rangeConstraint": "NONCONTIGUOUS" },
            }] });
            let end = film.as_ref().map(|film| {
                let (folder_of_film, film) = folder_and_name(film);
                parameters.push(folder("FilmFolder", &folder_of_film, "OUT"));
                let words = vec![
                    "film".into(),
                    output.clone(),
                    "-o".into(),
                    format!("{{{{Param.FilmFolder}}}}/{film}"),
                    "--fps".into(),
                    job.fps.to_string(),
                    "--frames".into(),
                    "{{Param.Frames}}".into(),
                ];
                ("Film", words)
            });
            (space, end)
        }
        Work::Tiles { tiles, frame } => {
            let part = |column: &str, row: &str| format!("{output}.parts/{column}-{row}.exr");
            render.push(part("{{Task.Param.Column}}", "{{Task.Param.Row}}"));
            let (columns, rows) = (tiles.columns, tiles.rows);
            let tile = format!("{{{{Task.Param.Column}}}},{{{{Task.Param.Row}}}}/{columns}x{rows}");
            render.extend(["--frames".into(), frame.to_string(), "--tile".into(), tile]);
            let space = json!({
                "taskParameterDefinitions": [
                    { "name": "Column", "type": "INT", "range": format!("1-{columns}") },
                    { "name": "Row", "type": "INT", "range": format!("1-{rows}") },
                ],
                "combination": "Column * Row",
            });
            let mut words = vec!["merge".into(), "-o".into(), output.clone()];
            words.extend(job.compressed());
            for row in 1..=rows {
                words.extend((1..=columns).map(|c| part(&c.to_string(), &row.to_string())));
            }
            (space, Some(("Merge", words)))
        }
    };
    // Tasks run in a folder of their own, so these are paths that the engine maps.
    for (index, assets) in job.assets.iter().enumerate() {
        let name = format!("Assets{}", index + 1);
        parameters.push(folder(&name, &text(assets), "IN"));
        render.extend(["--assets".into(), format!("{{{{Param.{name}}}}}")]);
    }
    render.extend(job.more.iter().cloned());
    render.extend(["--resume".into(), "--openjd".into()]);
    let mut steps = vec![json!({
        "name": "Render",
        "parameterSpace": space,
        "script": script(&render),
    })];
    if let Some((name, words)) = end {
        steps.push(json!({
            "name": name,
            "dependencies": [{ "dependsOn": "Render" }],
            "script": script(&words),
        }));
    }
    let mut template = json!({
        "specificationVersion": "jobtemplate-2023-09",
        "name": name.unwrap_or_else(|| "reflet".into()),
        "parameterDefinitions": parameters,
        "steps": steps,
    });
    if !extensions.is_empty() {
        template["extensions"] = json!(extensions);
    }
    let text = serde_json::to_string_pretty(&template)
        .map_err(|error| Failure::new(Exit::Failed, error.to_string()))?;
    Ok(text + "\n")
}

/// What a step runs. SIGTERM comes first when a task is cancelled; what is done is kept.
fn script(words: &[String]) -> Value {
    json!({ "actions": { "onRun": {
        "command": "{{Param.Reflet}}",
        "args": words,
        "cancelation": { "mode": "NOTIFY_THEN_TERMINATE", "notifyPeriodInSeconds": 10 },
    } } })
}

/// A parameter that is a folder. A path that begins at the root is no default of a template's, so
/// it stays what it is.
fn folder(name: &str, path: &str, flow: &str) -> Value {
    if Path::new(path).is_absolute() {
        return json!({ "name": name, "type": "STRING", "default": path });
    }
    json!({
        "name": name, "type": "PATH", "objectType": "DIRECTORY", "dataFlow": flow, "default": path
    })
}

fn folder_and_name(path: &Path) -> (String, String) {
    let folder = path.parent().map(text).filter(|folder| !folder.is_empty());
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
    (folder.unwrap_or_else(|| ".".into()), name.unwrap_or_default())
}
