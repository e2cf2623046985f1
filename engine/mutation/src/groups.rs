//! The sources that faults are planted in, and the tests that must notice them.

/// Sources of one crate, and the commands whose tests must notice a fault in them.
pub struct Group {
    /// How it is called on the command line.
    pub name: &'static str,
    /// The folder of the crate under `engine`.
    pub folder: &'static str,
    /// Files and folders under its `src`.
    pub sources: &'static [&'static str],
    /// Arguments of `cargo test`.
    pub tests: &'static [&'static [&'static str]],
    /// Arguments of `raxel`, which is run after the tests.
    pub stress: Option<&'static [&'static str]>,
}

/// `RAXEL_MUTATION_RAYS` rays that a fault in an encoder must lead astray.
const STRESS: &[&str] = &[
    "stress",
    "--scenes",
    "dust,sparse,gravel,motley,rubble,checkerboard,diagonal,slope,solid,boxes,corners,menger,hills",
];

/// Every group.
pub const GROUPS: &[Group] = &[
    Group {
        name: "plan",
        folder: "graph",
        sources: &[
            "back/alias.rs",
            "back/barriers",
            "back/cull.rs",
            "back/lifetimes.rs",
            "back/order.rs",
            "ir/subresources.rs",
            "back/unroll.rs",
            "back/updates.rs",
            "back/varies.rs",
        ],
        tests: &[&["-p", "raxel-graph"]],
        stress: None,
    },
    Group {
        name: "queues",
        folder: "graphfile",
        sources: &["queues.rs"],
        tests: &[&["-p", "raxel-graphfile"]],
        stress: None,
    },
    Group {
        name: "encode",
        folder: "layouts",
        sources: &[""],
        tests: &[
            &["-p", "raxel-layouts"],
            &["-p", "raxel-rivals"],
            // Of raxel-edit, and with the features of the whole workspace, as raxel itself is built.
            &["--workspace", "--test", "live", "--test", "live_hashed"],
        ],
        stress: Some(STRESS),
    },
    Group { name: "rivals", folder: "rivals", sources: &[""], tests: &[&["-p", "raxel-rivals"]], stress: Some(STRESS) },
];
