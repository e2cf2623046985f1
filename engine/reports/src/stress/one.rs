//! Single rays: read from the command line, traced by all, and written so that they can be read again.

use std::fmt::Write;
use std::sync::Arc;

use raxel_diagnostics::Files;
use raxel_gpu::Device;
use raxel_measure::rays::{RayError, State};
use raxel_measure::stress::{Plan, RowReport, Truth, single};
use raxel_oracle::exact::{Answer, Passage};
use raxel_oracle::instances::SceneHit;
use raxel_oracle::metrics::{Errors, Outcome, Wrong};
use raxel_oracle::period::{PeriodHit, PeriodRay, UNIT};
use raxel_oracle::{FAR, Hit, Lattice, Ray};
use raxel_terminal::console::{self, Console, Format};
use serde_json::{Value, json};

/// A ray as it is written on the command line.
#[derive(Clone, Debug)]
pub(super) struct NamedRay(pub Ray);

/// Reads nine numbers: three of the cell, three of the fraction, three of the direction; and `t_max`, if there is a tenth.
pub(super) fn ray(text: &str) -> Result<NamedRay, String> {
    let wrong = || {
        "write nine numbers, cell, fraction and direction (and t_max, if it ends), e.g. \"0 20 -5  0.5 0.5 0.5  0x3f800000 0 -1\"".to_owned()
    };
    let words: Vec<&str> = text.split([' ', ',', '\t']).filter(|word| !word.is_empty()).collect();
    let [x, y, z, floats @ ..] = words.as_slice() else { return Err(wrong()) };
    let cell: Option<Vec<i32>> = [x, y, z].iter().map(|word| word.parse().ok()).collect();
    let float = |word: &&str| match word.strip_prefix("0x") {
        Some(bits) => u32::from_str_radix(bits, 16).ok().map(f32::from_bits),
        None => word.parse().ok(),
    };
    let floats: Option<Vec<f32>> = floats.iter().map(float).collect();
    match (cell.as_deref(), floats.as_deref()) {
        (Some(_), Some(floats @ ([_, _, _, _, _, _] | [_, _, _, _, _, _, _])))
            if floats[..3].iter().any(|f| !f.is_nan() && !(0.0..=1.0).contains(f)) =>
        {
            Err("a fraction is a place in the cell, from 0 to 1".to_owned())
        }
        (Some(&[x, y, z]), Some(&[fx, fy, fz, dx, dy, dz, ref end @ ..])) if end.len() < 2 => {
            let ray = Ray::new([x, y, z], [fx, fy, fz], [dx, dy, dz]);
            Ok(NamedRay(Ray { t_max: end.first().copied().unwrap_or(ray.t_max), ..ray }))
        }
        _ => Err(wrong()),
    }
}

/// The ray as [`ray`] reads it, without the loss of a bit.
pub(super) fn written(ray: &Ray) -> String {
    let [x, y, z] = ray.cell;
    let bits = |v: [f32; 3]| v.map(|v| format!("{:#010x}", v.to_bits())).join(" ");
    let end = if ray.t_max < FAR { format!("  {:#010x}", ray.t_max.to_bits()) } else { String::new() };
    format!("{x} {y} {z}  {}  {}{end}", bits(ray.frac), bits(ray.dir))
}

const FACES: [&str; 7] = ["-X", "+X", "-Y", "+Y", "-Z", "+Z", "inside"];

fn hit_text(hit: &Hit) -> String {
    let [x, y, z] = hit.voxel;
    let face = FACES.get(hit.face as usize).copied().unwrap_or("?");
    let material = if hit.material == u32::MAX { "other than looked up".to_owned() } else { hit.material.to_string() };
    let [u, v] = hit.uv;
    format!("voxel {x} {y} {z}  face {face}  material {material}  t {}  uv {u} {v}", hit.t)
}

fn truth_text(ray: &Ray, truth: &Truth) -> String {
    match truth {
        Truth::Scene(None) => "nothing".to_owned(),
        Truth::Scene(Some(SceneHit { instance, voxel: [x, y, z], face, material, .. })) => {
            let whose = instance.map_or_else(|| "the world".to_owned(), |index| format!("instance {index}"));
            format!("voxel {x} {y} {z}  face {}  material {material}  of {whose}", FACES[*face as usize])
        }
        Truth::Ray(answer) | Truth::Edited(answer) => exact_text(ray, answer),
        Truth::Period(period, hit) => {
            let PeriodRay { octant, first, period, .. } = period;
            let ray = format!("(octant {octant}, first {first:?}, period {period:?})");
            let Some(PeriodHit { voxel: [x, y, z], face, material, time }) = hit else {
                return format!("nothing  {ray}");
            };
            let face = FACES[*face as usize];
            format!("voxel {x} {y} {z}  face {face}  material {material}  t {}  {ray}", *time as f64 / f64::from(UNIT))
        }
    }
}

fn exact_text(ray: &Ray, answer: &Answer) -> String {
    let tie = if answer.tie { "  (a tie)" } else { "" };
    let (Some(hit), Some(lattice)) = (&answer.hit, Lattice::of(ray)) else { return format!("nothing{tie}") };
    let [x, y, z] = hit.voxel;
    let chord = Passage::of(&lattice, hit.voxel).map_or(0.0, |passage| passage.length(&lattice));
    format!(
        "voxel {x} {y} {z}  face {}  material {}  t {}  chord {chord:.3e}{tie}",
        FACES[hit.face as usize],
        hit.material,
        hit.time.in_lengths(&lattice)
    )
}

fn truth_json(ray: &Ray, truth: &Truth) -> Value {
    match truth {
        Truth::Scene(hit) => {
            let hit = hit.as_ref().map(|hit| {
                json!({ "voxel": hit.voxel, "face": hit.face, "material": hit.material, "instance": hit.instance })
            });
            json!({ "hit": hit })
        }
        Truth::Ray(answer) | Truth::Edited(answer) => exact_json(ray, answer),
        Truth::Period(period, hit) => {
            let t = |hit: &PeriodHit| hit.time as f64 / f64::from(UNIT);
            let hit = hit
                .as_ref()
                .map(|hit| json!({ "voxel": hit.voxel, "face": hit.face, "material": hit.material, "t": t(hit) }));
            json!({ "hit": hit, "octant": period.octant, "first": period.first, "period": period.period })
        }
    }
}

fn exact_json(ray: &Ray, answer: &Answer) -> Value {
    let hit = answer.hit.as_ref().zip(Lattice::of(ray)).map(|(hit, lattice)| {
        json!({ "voxel": hit.voxel, "face": hit.face, "material": hit.material, "t": hit.time.in_lengths(&lattice) })
    });
    json!({ "hit": hit, "tie": answer.tie })
}

fn hit_json(hit: Option<&Hit>) -> Value {
    hit.map_or(Value::Null, |hit| {
        json!({ "voxel": hit.voxel, "face": hit.face, "material": hit.material, "t": hit.t, "uv": hit.uv, "steps": hit.steps })
    })
}

fn wrong_name(wrong: Wrong) -> String {
    serde_json::to_value(wrong).ok().and_then(|name| name.as_str().map(str::to_owned)).unwrap_or_default()
}

/// Traces one ray through every site by every row. Gives the rows that are wrong and claim not to be.
pub(super) fn trace(
    plan: &Plan,
    ray: &Ray,
    device: &Arc<Device>,
    files: &Arc<dyn Files>,
    console: &Console,
) -> Result<Vec<String>, RayError> {
    let mut broken = Vec::new();
    for (number, site) in plan.sites.iter().enumerate() {
        let found = single(plan, number, ray, device, files)?;
        let mut text =
            format!("{}  ray {}\n  {:<16} {}\n", site.name, written(ray), "exact", exact_text(ray, &found.exact));
        for (row, truth, answer) in &found.rows {
            let (said, wrong) = match answer {
                Err(why) => (why.clone(), None),
                Ok((state, hit)) => {
                    let outcome = match state {
                        State::Hang => Outcome::Hang,
                        State::Unwritten => Outcome::Unwritten,
                        State::Hit | State::Miss => Outcome::from(hit.as_ref()),
                    };
                    let said = match (state, hit) {
                        (State::Hang, _) => "gives up".to_owned(),
                        (State::Unwritten, _) => "writes nothing".to_owned(),
                        (_, Some(hit)) => format!("{}  after {} looks", hit_text(hit), hit.steps),
                        (_, None) => "nothing".to_owned(),
                    };
                    let wrong = truth.judge(&mut Errors::default(), ray, row, outcome);
                    (said, wrong.map(wrong_name))
                }
            };
            if console.format() == Format::Json {
                let hit = answer.as_ref().ok().and_then(|(_, hit)| hit.as_ref());
                console::json(&json!({
                    "reason": "ray", "site": site.name, "ray": written(ray), "row": row.to_string(), "said": said, "wrong": wrong,
                    "exact": truth_json(ray, truth), "hit": hit_json(hit),
                }));
            }
            if wrong.is_some() && row.exact() {
                broken.push(format!("{row} is wrong about the ray in {}", site.name));
            }
            let right = match truth {
                Truth::Ray(_) => String::new(),
                truth @ (Truth::Period(..) | Truth::Scene(_) | Truth::Edited(_)) => {
                    format!(", exactly {}", truth_text(ray, truth))
                }
            };
            let mark = wrong.map_or_else(String::new, |wrong| format!("  WRONG: {wrong}{right}"));
            let _ = writeln!(text, "  {:<16} {said}{mark}", row.to_string());
        }
        if console.format() != Format::Json {
            console::data(&text);
        }
    }
    Ok(broken)
}

/// The first wrong rays of a row, each with the command that traces it alone.
pub(super) fn show_wrong(plan: &Plan, row: &RowReport, console: &Console) {
    let shown = if console.verbose() { row.wrong.len() } else { 3 };
    for sample in row.wrong.iter().take(shown) {
        let (site, set) = (&plan.sites[sample.site].name, plan.sets[sample.set].name);
        let at = if site.contains('@') { format!("--scenes {site}") } else { format!("--world {site}") };
        // A beam is for a tile of rays, and this is one of them.
        let which = if row.row.traces_alone() {
            format!("--ray \"{}\"", written(&sample.ray))
        } else {
            format!("--sets {set} --rays {}", plan.rays)
        };
        let command = format!("raxel stress {at} --layouts {} --seed {} {which}", row.row, plan.seed);
        if console.format() == Format::Json {
            console::json(&json!({
                "reason": "wrong-ray", "row": row.row.to_string(), "site": site, "set": set, "wrong": sample.wrong,
                "ray": written(&sample.ray), "exact": truth_json(&sample.ray, &sample.exact),
                "hit": hit_json(sample.found.as_ref()), "command": command,
            }));
            continue;
        }
        let found = sample.found.as_ref().map_or_else(|| "nothing".to_owned(), hit_text);
        console.message(&format!(
            "{} in {site}, {set}: {}\n  exact  {}\n  found  {found}\n  {command}",
            row.row,
            wrong_name(sample.wrong),
            truth_text(&sample.ray, &sample.exact)
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_are_read_as_they_are_written() {
        let made = Ray::new([-5, i32::MAX, 7], [0.25, 1.0, f32::from_bits(3)], [-0.0, 1e-40, f32::NEG_INFINITY]);
        let read = ray(&written(&made)).expect("a ray").0;
        assert_eq!(read.cell, made.cell);
        assert_eq!(
            [read.frac, read.dir].map(|v| v.map(f32::to_bits)),
            [made.frac, made.dir].map(|v| v.map(f32::to_bits))
        );
        let ends = Ray { t_max: 0.75, ..made };
        assert_eq!(ray(&written(&ends)).expect("a ray").0.t_max.to_bits(), 0.75f32.to_bits());
        assert_eq!(
            ray("0,1,-2, 0.5,0.5,0.5, 1,0,-1").expect("a ray").0,
            Ray::new([0, 1, -2], [0.5; 3], [1.0, 0.0, -1.0])
        );
        for wrong in
            ["", "1 2 3", "1 2 3 4 5 6 7 8", "1 2 3 0 0 0 7 8 9 10 11", "x 2 3 4 5 6 7 8 9", "0.5 2 3 4 5 6 7 8 9"]
        {
            assert!(ray(wrong).is_err(), "{wrong}");
        }
    }
}
