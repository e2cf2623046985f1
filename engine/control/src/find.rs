//! Numbers of targets: the statistics of a slice, and the place of a value in all slices.

use raxel_execute::Texels;
use raxel_picture::{Place, Search, Sought, Statistics};
use raxel_runtime::Session;
use raxel_runtime::debug_target::DebugTarget;
use serde_json::{Value, json};

use super::read::{self, Middle};
use super::refusal::Refusal;
use super::request::{Find, Found};

/// Statistics of each channel of a slice.
pub(super) fn statistics(
    session: &mut Session,
    target: &DebugTarget,
    middle: Option<&Middle>,
) -> Result<Value, Refusal> {
    let texels = read::texels_of(session, target, middle)?;
    let of = |channel| {
        let found = Statistics::of(texels.channel(channel).into_iter())?;
        let [smallest, largest] = found.range;
        Some(json!({
            "count": found.count, "nan": found.nan, "infinite": found.infinite,
            "smallest": smallest, "largest": largest, "mean": found.mean,
            "percentiles": found.percentiles, "histogram": found.histogram.as_slice(),
        }))
    };
    let channels: Vec<Value> = (0..texels.format.channels()).filter_map(of).collect();
    Ok(json!({
        "width": texels.width, "height": texels.height, "format": texels.format.name(), "channels": channels,
    }))
}

/// The next texel with a value, in one slice of a target or in all.
pub(super) fn find(session: &mut Session, find: &Find, middle: Option<&Middle>) -> Result<Value, Refusal> {
    let sought = sought(&find.value)?;
    let slices = slices(session, find)?;
    let one = |[mip, layer]: [u32; 2]| DebugTarget {
        resource: find.target.clone(),
        age: find.age,
        mip,
        layer,
        after: find.after.clone(),
    };
    let (start, from) = begin(session, find, &slices)?;
    let mut search = Search::new(sought, find.forward, slices.len(), start, from);
    while let Some(slice) = search.slice() {
        let texels = read::texels_of(session, &one(slices[slice]), middle)?;
        let channels = texels.format.channels();
        if find.channel >= channels {
            let message = format!("`{}` has the channels 0 to {}; got {}", find.target, channels - 1, find.channel);
            return Err(Refusal::new(message));
        }
        search.look(&texels.channel(find.channel));
    }
    let [looked, _] = search.progress();
    let Some(Place { slice, index }) = search.found() else {
        return Ok(json!({ "found": null, "slices": looked }));
    };
    // The contents are those of the last frame: reading again gives the same.
    let texels = read::texels_of(session, &one(slices[slice]), middle)?;
    let ([x, y], [mip, layer]) = (place(&texels, index), slices[slice]);
    let mut answer = read::values(&texels, [x, y]);
    answer["found"] = json!({ "mip": mip, "layer": layer, "x": x, "y": y });
    answer["slices"] = looked.into();
    Ok(answer)
}

fn sought(word: &str) -> Result<Sought, Refusal> {
    let found = Sought::ALL.into_iter().find(|sought| sought.word().eq_ignore_ascii_case(word));
    found.ok_or_else(|| {
        let words = Sought::ALL.map(|sought| format!("`{}`", sought.word().to_lowercase())).join(", ");
        Refusal::new(format!("`value` must be one of {words}; got `{word}`"))
    })
}

/// Mip and layer of the slices that are looked at.
fn slices(session: &Session, find: &Find) -> Result<Vec<[u32; 2]>, Refusal> {
    let name = &find.target;
    // Of the output of a pass, the last frame has a copy of one slice alone.
    if find.after.is_some() {
        return Ok(vec![[find.mip.unwrap_or(0), find.layer.unwrap_or(0)]]);
    }
    let target = DebugTarget { resource: name.clone(), age: find.age, ..DebugTarget::default() };
    let resource = target.resolve(session.graph())?.resource;
    let size = session.plan().and_then(|plan| plan.sizes.get(resource.0 as usize));
    let Some(size) = size else {
        return Err(Refusal::new(format!("`{name}` has no size yet: run a frame with `step`")));
    };
    let wanted = |&[mip, layer]: &[u32; 2]| {
        find.mip.is_none_or(|wanted| wanted == mip) && find.layer.is_none_or(|wanted| wanted == layer)
    };
    let slices: Vec<[u32; 2]> = size.slices().filter(wanted).collect();
    if size.slices().next().is_none() {
        return Err(Refusal::new(format!("`{name}` is a buffer: only targets have texels")));
    }
    if slices.is_empty() {
        let part = |word: &str, part: Option<u32>| part.map_or(String::new(), |part| format!(" {word} {part}"));
        let (mip, layer) = (part("mip", find.mip), part("layer", find.layer));
        return Err(Refusal::new(format!("`{name}` has no{mip}{layer}")));
    }
    Ok(slices)
}

/// The slice and the texel after which the search begins.
fn begin(session: &Session, find: &Find, slices: &[[u32; 2]]) -> Result<(usize, Option<usize>), Refusal> {
    let Some(Found { mip, layer, x, y }) = find.from else {
        // The first of all, or the last.
        return Ok((if find.forward { 0 } else { slices.len() - 1 }, None));
    };
    let slice = slices.iter().position(|slice| *slice == [mip, layer]);
    let resource = session.graph().find_resource(&find.target);
    let sizes = session.plan().map(|plan| &plan.sizes);
    let size = resource.zip(sizes).and_then(|(resource, sizes)| sizes.get(resource.0 as usize)?.texels(mip));
    match (slice, size) {
        (Some(slice), Some([width, height, _])) if x < width && y < height => {
            Ok((slice, Some(y as usize * width as usize + x as usize)))
        }
        _ => Err(Refusal::new(format!("`from` is no texel that is searched: mip {mip}, layer {layer}, {x}, {y}"))),
    }
}

fn place(texels: &Texels, index: usize) -> [u32; 2] {
    let width = texels.width.max(1) as usize;
    [index % width, index / width].map(|place| u32::try_from(place).unwrap_or(u32::MAX))
}
