//! Charts.
use super::files::About;
use raxel_runtime::bench::Row;
pub(super) fn draw(_: &[Row], _: &About) -> Option<String> {
    None
}
