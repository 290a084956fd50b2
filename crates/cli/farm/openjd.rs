//! An Open Job Description template (2023-09, with the extension TASK_CHUNKING).

use super::{CHUNK, FarmJob, Work};
use crate::exit::{Exit, Failure};
use reflet_frame::resume::ranges;
use serde_json::{Value, json};
use std::path::Path;

/// The most characters that a parameter's default may have.
const MOST_TEXT: usize = 1024;
/// The most characters of a job's name, without extensions.
const MOST_NAME: usize = 128;

/// The parameters of a template.
#[derive(Default)]
struct Parameters {
    definitions: Vec<Value>,
    literals: usize,
}

impl Parameters {
    /// Text as a format string gives it back. There, `{{` begins an expression and cannot be
    /// escaped; the value of a parameter is no format string.
    fn literal(&mut self, text: &str) -> String {
        if !text.contains(['{', '}']) {
            return text.to_owned();
        }
        self.literals += 1;
        let name = format!("Text{}", self.literals);
        let expression = format!("{{{{Param.{name}}}}}");
        self.definitions.push(json!({ "name": name, "type": "STRING", "default": text }));
        expression
    }

    /// A folder, as an expression that begins paths in it. A path that begins at the root is no
    /// default of a template's, so it stays what it is.
    fn folder(&mut self, name: &str, path: &str, flow: &str) -> String {
        self.definitions.push(if Path::new(path).is_absolute() {
            json!({ "name": name, "type": "STRING", "default": path })
        } else {
            json!({
                "name": name, "type": "PATH", "objectType": "DIRECTORY", "dataFlow": flow,
                "default": path
            })
        });
        format!("{{{{Param.{name}}}}}")
    }

    /// A file, as an expression; its folder is a parameter of this name.
    fn file(&mut self, name: &str, path: &str, flow: &str) -> String {
        let (folder, file) = folder_and_name(path);
        let folder = self.folder(name, &folder, flow);
        format!("{folder}/{}", self.literal(&file))
    }
}

/// The template, as JSON.
///
/// # Errors
/// Names or frames that a template has no room for.
pub fn template(job: &FarmJob) -> Result<String, Failure> {
    let name = Path::new(&job.script).file_stem().map(|stem| stem.to_string_lossy());
    // A job's name is a format string, too.
    let name: String = name
        .unwrap_or_default()
        .chars()
        .map(|c| if matches!(c, '{' | '}') { '_' } else { c })
        .take(MOST_NAME)
        .collect();
    let mut parameters = Parameters::default();
    let scene = parameters.file("SceneFolder", &job.script, "IN");
    let output = parameters.file("OutputFolder", &job.output, "OUT");
    let mut render: Vec<String> = vec!["render".into(), scene, "-o".into()];
    let reflet = json!({ "name": "Reflet", "type": "STRING", "default": "reflet" });
    parameters.definitions.push(reflet);
    let mut extensions: Vec<&str> = Vec::new();
    let (space, end) = match &job.work {
        Work::Frames { frames, chunk, film } => {
            extensions.push("TASK_CHUNKING");
            parameters.definitions.push(json!({
                "name": "Frames", "type": "STRING", "default": ranges(frames)
            }));
            render.push(output.clone());
            render.extend(["--frames".into(), "{{Task.Param.Frame}}".into()]);
            let space = json!({ "taskParameterDefinitions": [{
                "name": "Frame",
                "type": "CHUNK[INT]",
                "range": "{{Param.Frames}}",
                "chunks": {
                    "defaultTaskCount": chunk.unwrap_or(CHUNK), "rangeConstraint": "NONCONTIGUOUS"
                },
            }] });
            let end = film.as_ref().map(|film| {
                let words = vec![
                    "film".into(),
                    output.clone(),
                    "-o".into(),
                    parameters.file("FilmFolder", film, "OUT"),
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
        render.extend(["--assets".into(), parameters.folder(&name, assets, "IN")]);
    }
    render.extend(job.more.iter().map(|word| parameters.literal(word)));
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
    fits(&parameters)?;
    let mut template = json!({
        "specificationVersion": "jobtemplate-2023-09",
        "name": name,
        "parameterDefinitions": parameters.definitions,
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

/// Holds the parameters against what a template may have.
fn fits(parameters: &Parameters) -> Result<(), Failure> {
    for definition in &parameters.definitions {
        let text = definition["default"].as_str().unwrap_or_default();
        if text.chars().count() > MOST_TEXT {
            let begin: String = text.chars().take(40).collect();
            return Err(Failure::usage(format!(
                "a parameter of an Open Job Description template holds at most {MOST_TEXT} \
                 characters, too few for `{begin}...`: take shorter names, or --frames in fewer \
                 ranges"
            )));
        }
    }
    Ok(())
}

fn folder_and_name(path: &str) -> (String, String) {
    let path = Path::new(path);
    let folder = path.parent().map(|p| p.to_string_lossy()).filter(|folder| !folder.is_empty());
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
    (folder.map_or_else(|| ".".into(), Into::into), name.unwrap_or_default())
}
