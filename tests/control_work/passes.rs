//! A pass that does not end is given up.

use serde_json::json;

use crate::common::{Project, eventually};
use crate::{Runs, Stage};

/// Works for minutes on the software driver: it leaves a loop after 65535 rounds, so a round is long and the groups are many.
const SPIN: &str = include_str!("../fixtures/control_work/spin.comp");

#[test]
fn a_pass_that_does_not_end_is_given_up_by_a_request() {
    let project = Project::empty();
    project.write("graphs/spin.toml", include_str!("../fixtures/control_work/spin.toml"));
    project.write("shaders/spin.comp", SPIN);
    let mut stage = Stage::over(project, Runs::Window, &["graphs/spin.toml", "--size", "320x180", "--watchdog", "600"]);
    eventually("the pass is given up", || {
        let answer = stage.talk.ask(json!({ "do": "cancel" }));
        answer["cancelled"] == json!(true) && answer["pass"] == json!("spin")
    });
    assert_eq!(stage.ask(json!({ "do": "cancel" }))["cancelled"], json!(false));
    stage.ends();
}
