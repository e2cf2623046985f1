//! The requested things, found by their names.

use std::collections::HashSet;
use std::path::Path;

use raxel_diagnostics::names;
use raxel_layouts::Layout;
use raxel_measure::rays::Method;
use raxel_measure::stress::{Row, Site, Sites};
use raxel_oracle::scenes::{self, Scene};
use raxel_oracle::sets::{self, RaySet};
use raxel_runtime::project::Project;
use raxel_terminal::args::each_once;
use raxel_terminal::console::Console;
use raxel_terminal::failure::{Failure, Result};
use raxel_terminal::offline::OfflineProject;

/// Marchers of `<raxel/rivals/march.glsl>`.
pub(super) const MARCHERS: &[&str] = &["fixed", "rollback", "dda", "stackless", "stack", "raymask"];

/// The largest number of rays that is taken for meant.
const MOST: f64 = 1e13;

/// A number of rays: `1e9`, `250000`.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the number is in 1…`MOST`")]
pub(super) fn count(text: &str) -> std::result::Result<u64, String> {
    text.replace('_', "")
        .parse()
        .ok()
        .filter(|rays: &f64| (1.0..=MOST).contains(rays))
        .map(|rays| rays.round() as u64)
        .ok_or_else(|| "a number of rays from 1 to 1e13, e.g. 1e9".to_owned())
}

/// The project around the current folder, if there is one.
pub(super) fn offline() -> Option<OfflineProject> {
    OfflineProject::around(Path::new(".")).ok()
}

fn unknown<'n>(what: &str, name: &str, names: impl Iterator<Item = &'n str> + Clone) -> Failure {
    let failure = Failure::usage(format!("there is no {what} `{name}`"));
    match names::closest(name, names.clone()) {
        Some(close) => failure.help(format!("did you mean `{close}`?")),
        None => failure.help(format!("{what}s: {}", names::list(names))),
    }
}

pub(super) fn sets(wanted: &[String]) -> Result<Vec<&'static RaySet>> {
    if wanted.is_empty() {
        return Ok(sets::ALL.iter().collect());
    }
    let names = sets::ALL.iter().map(|set| set.name);
    let find = |name: &String| RaySet::find(name).ok_or_else(|| unknown("set", name, names.clone()));
    each_once(wanted.to_vec()).iter().map(find).collect()
}

pub(super) fn sites(wanted: &[String]) -> Result<Vec<Site>> {
    let both = |scene| [Sites::Near, Sites::Far].map(|at| Site::scene(scene, at));
    if wanted.is_empty() {
        return Ok(scenes::ALL.iter().flat_map(both).collect());
    }
    let mut found = Vec::new();
    for wanted in wanted {
        let (name, at) = wanted.split_once('@').unwrap_or((wanted, ""));
        let scene =
            Scene::find(name).ok_or_else(|| unknown("scene", name, scenes::ALL.iter().map(|scene| scene.name)))?;
        match at {
            "" => found.extend(both(scene)),
            "near" => found.push(Site::scene(scene, Sites::Near)),
            "far" => found.push(Site::scene(scene, Sites::Far)),
            at => return Err(unknown("site", at, ["near", "far"].into_iter())),
        }
    }
    // `menger` and `menger@far` name the far one twice.
    let mut named = HashSet::new();
    found.retain(|site| named.insert(site.name.clone()));
    Ok(found)
}

pub(super) fn world(named: &Path, console: &Console) -> Result<Vec<Site>> {
    let (offline, path) = OfflineProject::of(Some(named), Project::default_world, console)?;
    let world = offline.whole_world(&path, console)?;
    Ok(vec![Site::world(path, std::sync::Arc::new(world.voxels().clone()))])
}

pub(super) fn rows(wanted: &[String]) -> Result<Vec<Row>> {
    if wanted.is_empty() {
        let layouts = raxel_rivals::LAYOUTS.iter().map(|&layout| Row::Device(Method::of(layout)));
        let marchers = MARCHERS.iter().map(|marcher| match *marcher {
            // Its masks are those of bricks; over `tree64` it is the tree's own tracer.
            "raymask" => marched(raxel_rivals::BRICKMAP, marcher),
            _ => marched(Layout::TREE64, marcher),
        });
        // The default tracer first, its port behind it.
        let mut rows: Vec<Row> = [Row::default_tracer(), Row::Port].into();
        rows.extend(layouts.filter(|row| *row != Row::default_tracer()));
        rows.extend(raxel_rivals::LAYOUTS.iter().map(|&layout| marched(layout, Row::AHEAD)));
        let tiles = [Row::BEAM, Row::PACKET, Row::PARALLEL, Row::PARALLEL_ANY];
        rows.extend(tiles.map(|marcher| marched(Layout::TREE64, marcher)));
        rows.extend(Row::PERIODS.map(|marcher| marched(Layout::FLAT64, marcher)));
        let over_tree64 = [Row::INSTANCES, Row::ONWARD, Row::INSTANCES_ONWARD, Row::STREAMED];
        rows.extend(over_tree64.map(|marcher| marched(Layout::TREE64, marcher)));
        rows.extend(stored_layouts().map(|layout| marched(layout, Row::STORED)));
        rows.extend(marchers);
        return Ok(rows);
    }
    let mut rows = each_once(wanted.iter().map(|name| row(name)).collect::<Result<Vec<_>>>()?);
    // The port is compared with earlier answers of the device.
    rows.sort_by_key(|row| *row == Row::Port);
    Ok(rows)
}

/// The layouts in whose buffers shaders store voxels.
fn stored_layouts() -> impl Iterator<Item = Layout> {
    raxel_rivals::LAYOUTS.iter().copied().filter(|layout| layout.has_set() && !layout.has_image())
}

fn marched(layout: Layout, marcher: &str) -> Row {
    Row::Device(Method { layout, marcher: Some(marcher.to_owned()) })
}

fn row(name: &str) -> Result<Row> {
    let (layout, marcher) = name.split_once(':').unwrap_or((name, ""));
    let names = raxel_rivals::LAYOUTS.iter().map(|layout| layout.name());
    let layout = raxel_rivals::layout(layout).ok_or_else(|| unknown("layout", layout, names))?;
    match marcher {
        "" => Ok(Row::Device(Method::of(layout))),
        "cpu" if layout == Layout::TREE64 => Ok(Row::Port),
        "cpu" => Err(Failure::usage("only `tree64` has a port to the CPU").help("--layouts tree64,tree64:cpu")),
        marcher if Row::PERIODS.contains(&marcher) && layout != Layout::FLAT64 => {
            Err(Failure::usage("only `flat64` has period rays").help("--layouts flat64:period,flat64:refill"))
        }
        Row::STREAMED if layout != Layout::TREE64 => {
            Err(Failure::usage("streamed worlds are in the layout `tree64`").help("--layouts tree64:streamed"))
        }
        Row::STORED if stored_layouts().all(|stored| stored != layout) => {
            let rows = stored_layouts().map(|layout| format!("{}:{marcher}", layout.name())).collect::<Vec<_>>();
            Err(Failure::usage(format!("no shader stores voxels in a buffer of the layout `{}`", layout.name()))
                .help(format!("--layouts {}", rows.join(","))))
        }
        marcher if MARCHERS.contains(&marcher) || Row::WAYS.contains(&marcher) => Ok(marched(layout, marcher)),
        marcher => Err(unknown("marcher", marcher, MARCHERS.iter().copied().chain(Row::WAYS))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_rays() {
        assert_eq!(
            ["1e9", "400000", "1_000", "2.5e6"].map(count),
            [Ok(1_000_000_000), Ok(400_000), Ok(1000), Ok(2_500_000)]
        );
        for wrong in ["", "0", "-5", "1e99", "many", "nan"] {
            assert!(count(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn rows_have_the_names_they_are_found_by() {
        for row in rows(&[]).expect("all") {
            assert_eq!(super::row(&row.to_string()).expect("a row"), row);
        }
        let help = |name: &str| row(name).expect_err("wrong").help.concat();
        assert!(help("tree46").contains("`tree64`") && help("tree64:dad").contains("`dda`"));
        assert!(sites(&["hils".into()]).expect_err("wrong").help.concat().contains("`hills`"));
    }
}
