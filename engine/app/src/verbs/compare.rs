//! `raxel compare`: how far a picture, or a folder of them, is from a reference.

use std::path::{Path, PathBuf};

use raxel_output::{Pending, write_picture};
use raxel_picture::{Comparison, Picture};
use raxel_terminal::args::Messages;
use raxel_terminal::console::{self, Console, Format};
use raxel_terminal::failure::{Exit, Failure, Result};
use serde_json::json;

/// Compares a picture with a reference: mean FLIP error (0 equal, 1 black for white), root mean square, largest difference.
///
/// The exit code is 1 if one of them is over its threshold; without a threshold, if the pictures differ at all.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Two folders are compared file by file; a file that is in one of them only is a difference.\n\n\
                        Example: raxel compare reference.png picture.png --flip 0.01 --heat heat.png"
)]
pub(crate) struct Args {
    /// PNG, JPEG, HDR or EXR; or a folder of them.
    #[arg(value_name = "REFERENCE")]
    reference: PathBuf,

    /// As the reference.
    #[arg(value_name = "PICTURE")]
    other: PathBuf,

    /// Largest mean FLIP error.
    #[arg(long, value_name = "ERROR", value_parser = threshold)]
    flip: Option<f64>,

    /// Largest root mean square of the differences: of 0 to 1 for PNG and JPEG, of the numbers as they are for HDR and EXR.
    #[arg(long, value_name = "ERROR", value_parser = threshold)]
    rmse: Option<f64>,

    /// Largest difference of two numbers, in the unit of --rmse.
    #[arg(long, value_name = "ERROR", value_parser = threshold)]
    max: Option<f64>,

    /// Of EXR files, compare this layer; the first by default.
    #[arg(long, value_name = "NAME")]
    layer: Option<String>,

    /// Write the FLIP error of each pixel in colours, from black over purple to yellow. For folders, an existing folder.
    #[arg(long, value_name = "FILE.png")]
    heat: Option<PathBuf>,

    #[command(flatten)]
    pub messages: Messages,
}

fn threshold(text: &str) -> std::result::Result<f64, String> {
    text.parse().ok().filter(|value: &f64| *value >= 0.0).ok_or_else(|| "a number from 0 up".to_owned())
}

pub(crate) fn run(args: &Args, console: &Console) -> Result {
    let pairs = pairs(args)?;
    let count = pairs.len();
    let mut failed = 0;
    for Pair { name, reference, other, heat } in pairs {
        let good = match (reference, other) {
            (Some(reference), Some(other)) => one(args, &name, [&reference, &other], heat.as_deref(), console)?,
            (there, _) => {
                let (where_, not) =
                    if there.is_some() { (&args.reference, &args.other) } else { (&args.other, &args.reference) };
                say(&name, &format!("is in `{}` and not in `{}`", where_.display(), not.display()), console);
                false
            }
        };
        failed += usize::from(!good);
    }
    match failed {
        0 => Ok(()),
        1 if count == 1 => Err(Failure::new(Exit::Check, "the pictures differ")),
        _ => Err(Failure::new(Exit::Check, format!("{failed} of {count} pictures differ"))),
    }
}

/// Two files of one name.
struct Pair {
    name: String,
    reference: Option<PathBuf>,
    other: Option<PathBuf>,
    heat: Option<PathBuf>,
}

fn pairs(args: &Args) -> Result<Vec<Pair>> {
    let folders = [&args.reference, &args.other].map(|path| path.is_dir());
    match folders {
        [false, false] => {
            let name = args.other.display().to_string();
            let (reference, other) = (Some(args.reference.clone()), Some(args.other.clone()));
            Ok(vec![Pair { name, reference, other, heat: args.heat.clone() }])
        }
        [true, true] => {
            let [here, there] = [&args.reference, &args.other].map(|folder| pictures(folder));
            let (here, there) = (here?, there?);
            let mut names: Vec<String> = here.iter().chain(&there).cloned().collect();
            names.sort();
            names.dedup();
            if names.is_empty() {
                return Err(Failure::usage("there is no picture in the folders"));
            }
            let inside =
                |names: &[String], folder: &Path, name: &String| names.contains(name).then(|| folder.join(name));
            let pair = |name: String| Pair {
                reference: inside(&here, &args.reference, &name),
                other: inside(&there, &args.other, &name),
                heat: args.heat.as_ref().map(|folder| folder.join(&name).with_extension("png")),
                name,
            };
            Ok(names.into_iter().map(pair).collect())
        }
        _ => Err(Failure::usage("one is a folder and the other is not")),
    }
}

/// Names of the pictures in a folder.
fn pictures(folder: &Path) -> Result<Vec<String>> {
    let failed = |error: std::io::Error| Failure::usage(format!("`{}` cannot be read: {error}", folder.display()));
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let name = entry.map_err(failed)?.file_name().to_string_lossy().into_owned();
        let extension = Path::new(&name).extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        if ["png", "jpg", "jpeg", "exr", "hdr"].contains(&extension.as_str()) {
            names.push(name);
        }
    }
    Ok(names)
}

/// Compares two files. False when they are further apart than they may be.
fn one(args: &Args, name: &str, paths: [&Path; 2], heat: Option<&Path>, console: &Console) -> Result<bool> {
    let [reference, other] = paths.map(|path| read(path, args.layer.as_deref()));
    let (reference, other) = (reference?, other?);
    let found = match raxel_picture::compare(&reference, &other) {
        Ok(found) => found,
        Err(error) => {
            say(name, &error.to_string(), console);
            return Ok(false);
        }
    };
    if let Some(heat) = heat {
        let rgba = found.heat.chunks_exact(3).flat_map(|pixel| [pixel[0], pixel[1], pixel[2], 255]).collect();
        let picture = raxel_execute::Picture { width: reference.width, height: reference.height, rgba };
        write_picture(Pending::new(heat)?, &picture)?;
    }
    let good = args.judge(&found);
    match console.format() {
        Format::Json => console::json(&json!({
            "reason": "compared",
            "file": name,
            "flip": found.flip,
            "rmse": found.rmse,
            "max": found.max.is_finite().then_some(found.max),
            "differing": found.differing,
            "ok": good,
        })),
        _ => console::data(&format!(
            "{name}: FLIP {:.6}, RMSE {:.6}, max {:.6}, {} of {} pixels differ\n",
            found.flip,
            found.rmse,
            found.max,
            found.differing,
            reference.pixels.len()
        )),
    }
    Ok(good)
}

impl Args {
    fn judge(&self, found: &Comparison) -> bool {
        let limits = [(self.flip, found.flip), (self.rmse, found.rmse), (self.max, found.max)];
        if limits.iter().all(|(limit, _)| limit.is_none()) {
            return found.differing == 0;
        }
        limits.into_iter().all(|(limit, found)| limit.is_none_or(|limit| found <= limit))
    }
}

fn read(path: &Path, layer: Option<&str>) -> Result<Picture> {
    raxel_picture::read(path, layer)
        .map_err(|error| Failure::usage(format!("`{}` cannot be compared: {error}", path.display())))
}

fn say(name: &str, what: &str, console: &Console) {
    match console.format() {
        Format::Json => console::json(&json!({ "reason": "compared", "file": name, "ok": false, "message": what })),
        _ => console::data(&format!("{name}: {what}\n")),
    }
}
