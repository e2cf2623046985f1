//! Named values of params, in `.raxel/presets.toml` of the project: a table for each graph and, in it, one for each preset.

use std::collections::BTreeMap;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use raxel_output::replace;
use toml_edit::{Array, DocumentMut, Item, Table, TableLike, Value};

use super::write_back::{Written, implicit_table, text_of};

/// Project path of the file.
const FILE: &str = ".raxel/presets.toml";

/// The head of a new file.
const HEAD: &str = "# Presets of params: values by graph, name and param. The window and programs write them.\n";

/// Components of params, by their names.
pub type Values = BTreeMap<String, Vec<f64>>;

/// Presets by graph and name.
type ByGraph = BTreeMap<String, BTreeMap<String, Values>>;

/// The presets of a project.
pub struct Presets {
    path: PathBuf,
    /// As they were read last.
    known: ByGraph,
}

impl Presets {
    /// Of the project at a folder. [`Self::read`] finds the existing ones.
    pub fn of(project: &Path) -> Self {
        Self { path: project.join(FILE), known: ByGraph::new() }
    }

    /// Reads the file. If it cannot be read, the old values stay.
    ///
    /// # Errors
    /// Returns the fault of the file, in one line.
    pub fn read(&mut self) -> Result<(), String> {
        self.known = self.presets_in(&self.document()?)?;
        Ok(())
    }

    /// The presets in the text of the file.
    fn presets_in(&self, document: &DocumentMut) -> Result<ByGraph, String> {
        let tables = |item: &dyn TableLike| -> Vec<(String, Item)> {
            item.iter().map(|(name, item)| (name.to_owned(), item.clone())).collect()
        };
        let mut known = ByGraph::new();
        for (graph, presets) in tables(document.as_table()) {
            for (name, values) in presets.as_table_like().map(tables).unwrap_or_default() {
                let values = values.as_table_like().map(tables).unwrap_or_default();
                let read = values.into_iter().map(|(param, item)| {
                    let numbers = components(&item).ok_or_else(|| {
                        self.wrong(&format!("`{graph}`.`{name}`.`{param}` must be an array of numbers"))
                    })?;
                    Ok((param, numbers))
                });
                let read = read.collect::<Result<Values, String>>()?;
                known.entry(graph.clone()).or_default().insert(name, read);
            }
        }
        Ok(known)
    }

    /// The presets of a graph, by name.
    pub fn of_graph(&self, graph: &str) -> impl Iterator<Item = (&str, &Values)> {
        self.known.get(graph).into_iter().flatten().map(|(name, values)| (name.as_str(), values))
    }

    /// Keeps values under a name; a preset of that name is replaced, everything else in the file stays.
    ///
    /// # Errors
    /// Why the file cannot be read or written.
    pub fn save(&mut self, graph: &str, name: &str, values: &Values) -> Result<Written, String> {
        self.change(|document| {
            let presets = document.entry(graph).or_insert_with(implicit_table);
            let presets = presets.as_table_like_mut()?;
            let mut table = Table::new();
            for (param, numbers) in values {
                table.insert(param, Item::Value(Value::Array(numbers.iter().copied().collect::<Array>())));
            }
            presets.insert(name, Item::Table(table));
            Some(())
        })
    }

    /// Takes a preset out of the file.
    ///
    /// # Errors
    /// Why the file cannot be read or written.
    pub fn remove(&mut self, graph: &str, name: &str) -> Result<Written, String> {
        self.change(|document| {
            document.get_mut(graph)?.as_table_like_mut()?.remove(name);
            Some(())
        })
    }

    fn change(&mut self, edit: impl FnOnce(&mut DocumentMut) -> Option<()>) -> Result<Written, String> {
        // Another window may have written it, and a user.
        let before = text_of(&self.path).map_err(|error| self.wrong(&error.to_string()))?;
        let mut document = self.document()?;
        edit(&mut document).ok_or_else(|| self.wrong("what stands under the graph's name must be a table"))?;
        // A file with a mistake elsewhere stays as it is.
        let known = self.presets_in(&document)?;
        let mut text = document.to_string();
        if before.is_none() {
            text.insert_str(0, HEAD);
        }
        let written = self.path.parent().map_or(Ok(()), fs::create_dir_all);
        written.and_then(|()| replace(&self.path, text.as_bytes())).map_err(|error| self.wrong(&error.to_string()))?;
        self.known = known;
        Ok(Written::of(FILE, &self.path, before, text))
    }

    fn document(&self) -> Result<DocumentMut, String> {
        let text = match fs::read_to_string(&self.path) {
            Err(error) if error.kind() == ErrorKind::NotFound => String::new(),
            read => read.map_err(|error| self.wrong(&error.to_string()))?,
        };
        text.parse().map_err(|error: toml_edit::TomlError| self.wrong(error.message()))
    }

    fn wrong(&self, why: &str) -> String {
        format!("{}: {why}", self.path.display())
    }
}

/// The numbers of an array.
fn components(item: &Item) -> Option<Vec<f64>> {
    let number = |value: &Value| value.as_float().or_else(|| value.as_integer().map(|integer| integer as f64));
    item.as_array()?.iter().map(number).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(exposure: f64) -> Values {
        [("exposure".to_owned(), vec![exposure]), ("sun".to_owned(), vec![1.0, 0.5, 0.25])].into()
    }

    #[test]
    fn presets_are_kept_by_graph_and_what_is_written_beside_them_stays() {
        let project = tempfile::tempdir().unwrap();
        let mut presets = Presets::of(project.path());
        presets.read().unwrap();
        assert_eq!(presets.of_graph("graphs/a.toml").count(), 0);
        presets.save("graphs/a.toml", "noon", &values(2.0)).unwrap();
        presets.save("graphs/a.toml", "at dusk", &values(0.5)).unwrap();
        presets.save("graphs/b.toml", "noon", &values(9.0)).unwrap();
        let text = fs::read_to_string(&presets.path).unwrap();
        assert!(text.starts_with(HEAD), "{text}");
        // A user has written a comment and a whole number.
        let text = text.replace("exposure = [9.0]", "# bright\nexposure = [9]");
        fs::write(&presets.path, text).unwrap();
        presets.save("graphs/a.toml", "noon", &values(3.0)).unwrap();
        presets.remove("graphs/a.toml", "at dusk").unwrap();
        let mut again = Presets::of(project.path());
        again.read().unwrap();
        assert_eq!(again.of_graph("graphs/a.toml").collect::<Vec<_>>(), [("noon", &values(3.0))]);
        assert_eq!(again.of_graph("graphs/b.toml").collect::<Vec<_>>(), [("noon", &values(9.0))]);
        assert!(fs::read_to_string(&again.path).unwrap().contains("# bright"));
    }

    #[test]
    fn a_file_that_is_wrong_is_said_and_left_as_it_is() {
        let project = tempfile::tempdir().unwrap();
        let mut presets = Presets::of(project.path());
        presets.save("g", "a", &values(1.0)).unwrap();
        for (wrong, said) in [("[g.a]\nx = \"red\"\n", "`g`.`a`.`x` must be"), ("[g", "presets.toml")] {
            fs::write(&presets.path, wrong).unwrap();
            let error = presets.read().unwrap_err();
            assert!(error.contains(said), "{error}");
            assert_eq!(presets.of_graph("g").count(), 1, "what was known stays");
        }
        assert!(presets.save("g", "b", &values(2.0)).is_err());
        assert_eq!(fs::read_to_string(&presets.path).unwrap(), "[g");
        let mistaken = "[g.a]\nx = \"red\"\n";
        fs::write(&presets.path, mistaken).unwrap();
        for error in [presets.save("g", "b", &values(2.0)).unwrap_err(), presets.remove("g", "b").unwrap_err()] {
            assert!(error.contains("`g`.`a`.`x` must be"), "{error}");
        }
        assert_eq!(fs::read_to_string(&presets.path).unwrap(), mistaken);
        fs::write(&presets.path, "g = 3\n").unwrap();
        let error = presets.save("g", "b", &values(2.0)).unwrap_err();
        assert!(error.contains("must be a table"), "{error}");
    }
}
