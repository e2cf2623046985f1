//! The presets of a graph as the panel shows them.

use raxel_panels::view::{Param, Preset};
use raxel_workbench::presets::{Presets, Values};

/// The presets of a graph, beside the values that its params have now.
pub(crate) fn view(presets: &Presets, graph: &str, params: &[Param]) -> Vec<Preset> {
    let preset = |(name, values): (&str, &Values)| {
        let differing = params.iter().filter_map(|param| {
            let then = values.get(&param.name).filter(|then| **then != param.value)?;
            Some(format!("{}: {}, then {}", param.name, listed(&param.value), listed(then)))
        });
        Preset { name: name.to_owned(), differing: differing.collect() }
    };
    presets.of_graph(graph).map(preset).collect()
}

/// `1, 0.5, 0.25`.
fn listed(numbers: &[f64]) -> String {
    numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_preset_says_what_is_otherwise_now() {
        let project = tempfile::tempdir().unwrap();
        let mut presets = Presets::of(project.path());
        let values = [("exposure".to_owned(), vec![2.0]), ("sun".to_owned(), vec![1.0, 0.5, 0.25])].into();
        presets.save("g", "noon", &values).unwrap();
        let param =
            |name: &str, value: &[f64]| Param { name: name.to_owned(), value: value.to_vec(), ..Param::default() };
        // The graph has a param that the preset does not know, and not all that it knows.
        let now = [param("exposure", &[0.5]), param("new", &[1.0])];
        let differing = |now: &[Param]| view(&presets, "g", now).remove(0).differing;
        assert_eq!(differing(&now), ["exposure: 0.5, then 2"]);
        assert_eq!(
            differing(&[param("exposure", &[2.0]), param("sun", &[1.0, 0.5, 0.0])]),
            ["sun: 1, 0.5, 0, then 1, 0.5, 0.25"]
        );
        assert_eq!(differing(&[param("exposure", &[2.0])]), [""; 0]);
        assert_eq!(view(&presets, "other", &now), []);
    }
}
