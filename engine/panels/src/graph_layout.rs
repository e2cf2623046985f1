//! Places passes and resources in the picture of a graph, in columns from left to right by their dependencies.

use crate::view::{Pass, Resource};

/// The thing that a node stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Of {
    /// A pass, by its index.
    Pass(usize),
    /// A resource as a pass leaves it, both by their indices; without a pass, as the frame finds it.
    Resource { resource: usize, after: Option<usize> },
}

/// A node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Node {
    pub(crate) of: Of,
    /// From the left. Passes stand in odd columns.
    pub(crate) column: usize,
    /// From the top.
    pub(crate) row: f32,
}

/// Nodes, and edges from one to another by their indices.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Drawing {
    pub(crate) nodes: Vec<Node>,
    pub(crate) edges: Vec<[usize; 2]>,
}

/// Lays a graph out. A pass stands right of its inputs and left of its outputs.
pub(crate) fn lay_out(passes: &[Pass<'_>], resources: &[Resource]) -> Drawing {
    let mut drawing = Drawing::default();
    // The node of each resource as the last pass has left it.
    let mut newest: Vec<Option<usize>> = vec![None; resources.len()];
    for pass in 0..passes.len() {
        let used = |resource: &Resource| resource.uses.get(pass).copied().unwrap_or_default();
        let mut read = Vec::new();
        for (index, _) in resources.iter().enumerate().filter(|(_, resource)| used(resource).reads) {
            let found = || drawing.add(Of::Resource { resource: index, after: None }, 0);
            read.push(*newest[index].get_or_insert_with(found));
        }
        // A resource that it only writes must not stand left of the one that it replaces.
        let replaced = resources.iter().enumerate().filter(|(_, resource)| used(resource).writes);
        let replaced = replaced.filter_map(|(index, _)| newest[index]);
        let before = read.iter().copied().chain(replaced).map(|node| drawing.nodes[node].column).max();
        let node = drawing.add(Of::Pass(pass), before.map_or(1, |column| column + 1));
        drawing.edges.extend(read.into_iter().map(|from| [from, node]));
        let column = drawing.nodes[node].column + 1;
        for (index, _) in resources.iter().enumerate().filter(|(_, resource)| used(resource).writes) {
            let written = drawing.add(Of::Resource { resource: index, after: Some(pass) }, column);
            drawing.edges.push([node, written]);
            newest[index] = Some(written);
        }
    }
    drawing.place_rows();
    drawing
}

impl Drawing {
    fn add(&mut self, of: Of, column: usize) -> usize {
        self.nodes.push(Node { of, column, row: 0.0 });
        self.nodes.len() - 1
    }

    /// Columns from the left: each node beside the centre of those that lead to it, none over another.
    fn place_rows(&mut self) {
        let mut leading: Vec<Vec<usize>> = vec![Vec::new(); self.nodes.len()];
        for [from, to] in &self.edges {
            leading[*to].push(*from);
        }
        let columns = self.nodes.iter().map(|node| node.column).max().map_or(0, |last| last + 1);
        for column in 0..columns {
            let mut there: Vec<(f32, usize)> = (0..self.nodes.len())
                .filter(|node| self.nodes[*node].column == column)
                .map(|node| {
                    let rows: f32 = leading[node].iter().map(|from| self.nodes[*from].row).sum();
                    (rows / leading[node].len().max(1) as f32, node)
                })
                .collect();
            there.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let mut free = f32::NEG_INFINITY;
            for (wanted, node) in there {
                self.nodes[node].row = wanted.max(free);
                free = self.nodes[node].row + 1.0;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::{PassState, Use};

    fn resource(marks: &str) -> Resource {
        let used = |mark| Use { reads: matches!(mark, 'r' | 'b'), writes: matches!(mark, 'w' | 'b'), ..Use::default() };
        Resource { uses: marks.chars().map(used).collect(), ..Resource::default() }
    }

    fn passes(count: usize) -> Vec<Pass<'static>> {
        let pass =
            Pass { name: "p", after: "p", times: None, state: PassState::Ran, groups: "", place: "", output: None };
        vec![pass; count]
    }

    #[test]
    fn a_pass_stands_right_of_what_it_reads() {
        // The first pass reads the world and writes color; the second works on color in place; the third is by itself.
        let drawing = lay_out(&passes(3), &[resource("r.."), resource("wb."), resource("..w")]);
        let column = |of| drawing.nodes.iter().find(|node| node.of == of).map(|node| node.column);
        assert_eq!(column(Of::Resource { resource: 0, after: None }), Some(0));
        assert_eq!([0, 1, 2].map(|pass| column(Of::Pass(pass))), [Some(1), Some(3), Some(1)]);
        assert_eq!(column(Of::Resource { resource: 1, after: Some(0) }), Some(2));
        assert_eq!(column(Of::Resource { resource: 1, after: Some(1) }), Some(4));
        assert_eq!(drawing.edges.len(), 5);
        assert!(drawing.edges.iter().all(|[from, to]| drawing.nodes[*from].column < drawing.nodes[*to].column));
    }

    #[test]
    fn no_node_stands_on_another_and_a_target_that_is_written_again_goes_on() {
        let drawing = lay_out(&passes(4), &[resource("wwwr"), resource("w..r"), resource(".w.r"), resource("r..w")]);
        for (index, a) in drawing.nodes.iter().enumerate() {
            let apart = |b: &Node| a.column != b.column || (a.row - b.row).abs() >= 1.0;
            assert!(drawing.nodes[index + 1..].iter().all(apart), "{drawing:?}");
        }
        let order = [0, 1, 2, 3].map(|pass| drawing.nodes.iter().find(|n| n.of == Of::Pass(pass)).unwrap().column);
        assert_eq!(order, [1, 3, 5, 7]);
        assert_eq!(lay_out(&[], &[]), Drawing::default());
    }
}
