//! Sessions over the shipped files, on a real device with the validation layer on: no message may come.

use std::path::Path;

use raxel_graph::checked::Value;
use raxel_runtime::session::Validation;
use raxel_runtime::{Options, Session};

fn options() -> Options {
    Options {
        project: Some(Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")),
        size: [96, 54],
        validation: Validation::Required,
        ..Options::default()
    }
}

fn open(options: Options) -> Session {
    Session::open(options).unwrap_or_else(|error| panic!("{error}"))
}

fn assert_silent(session: &Session) {
    let messages = session.device().log().messages();
    assert!(messages.is_empty(), "{messages:#?}");
}

#[test]
fn the_shipped_graph_becomes_the_same_picture_each_time() {
    let picture = || {
        let mut session = open(options());
        session.frame().unwrap();
        let picture = session.read_presented().unwrap();
        assert_silent(&session);
        picture
    };
    let first = picture();
    assert_eq!((first.width, first.height, first.rgba.len()), (96, 54, 96 * 54 * 4));
    let colours: std::collections::HashSet<_> = first.rgba.chunks_exact(4).collect();
    assert!(colours.len() > 100, "{} colours", colours.len());
    assert!(first == picture());
}

#[test]
fn params_pushes_and_targets_are_driven_by_name() {
    let mut session = open(options());
    session.frame().unwrap();
    let bright = session.read_presented().unwrap();
    let exposure = session.param("exposure").unwrap();
    session.set_param("exposure", Value::F32(0.0)).unwrap();
    session.frame().unwrap();
    assert!(session.read_presented().unwrap().rgba.chunks_exact(4).all(|pixel| pixel[..3] == [0, 0, 0]));
    // A push value wins over the param that feeds it.
    session.set_push("primary", "exposure", exposure).unwrap();
    session.frame().unwrap();
    assert!(session.read_presented().unwrap() == bright);
    let texels = session.read_target("color").unwrap();
    assert_eq!((texels.width, texels.height), (96, 54));
    assert!(texels.floats().iter().flatten().all(|value| value.is_finite()));
    assert!(session.set_push("primary", "exposre", Value::F32(1.0)).unwrap_err().to_string().contains("`exposure`"));
    assert!(session.set_debug_target_text("colour").unwrap_err().to_string().contains("`color`"));
    assert_silent(&session);
}
