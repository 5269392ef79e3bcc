//! Annotations of clips: foot contacts, effective hits, unusable frames, names of ranges, classes of motion.

pub mod classes;
pub mod contacts;
mod ends;
pub mod hits;
mod sanity;
pub mod sidecar;

use crate::clip::{Clip, ClipSet, Exclusion};
use crate::{error::Result, mirror};
use classes::NameHints;
pub use contacts::{ContactConfig, GroundShape};
pub use ends::EndsConfig;
pub use hits::HitConfig;
use rayon::prelude::*;
pub use sanity::{ContactSanity, contact_sanity};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
pub use sidecar::{Sidecar, Sidecars};
use throng_core::Skeleton;

/// Settings of contacts, effective hits and unusable frames.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct AnnotateConfig {
    /// Foot contacts.
    pub contacts: ContactConfig,
    /// T-poses and stillness at the ends of clips.
    pub ends: EndsConfig,
    /// Effective hits.
    pub hits: HitConfig,
}

impl AnnotateConfig {
    /// Checks every number against its range.
    ///
    /// # Errors
    /// [`crate::error::BuildError::Key`] names the first one out of it.
    pub fn check(&self) -> Result<()> {
        self.contacts.check().map_err(|e| e.within_key("contacts"))?;
        self.ends.check().map_err(|e| e.within_key("ends"))?;
        self.hits.check().map_err(|e| e.within_key("hits"))
    }
}

/// Finds foot contacts, unusable ends, classes and effective hits of every clip, and adds what the sidecars mark.
///
/// Exclusions and tags that clips already have are kept. A mirrored copy that follows its original gets the original's
/// annotations, sides exchanged.
///
/// # Errors
/// [`crate::error::BuildError::Config`] for a setting outside its limits, for a sidecar of a clip that is not there,
/// or of a range
/// or hit outside its clip.
pub fn annotate(clips: &ClipSet, cfg: &AnnotateConfig, sidecars: &Sidecars) -> Result<ClipSet> {
    cfg.check().map_err(|e| e.within_key("annotate"))?;
    sidecars.check_names(clips.clips.iter().map(sidecar::original_name))?;
    let annotated = |c: &Clip| annotate_clip(c, &clips.skeleton, cfg, sidecars);
    let original = |c: &Clip| if c.mirrored { Ok(c.clone()) } else { annotated(c) };
    let originals: Vec<Clip> = clips.clips.par_iter().map(original).collect::<Result<_, _>>()?;
    let mut out: Vec<Clip> = Vec::with_capacity(originals.len());
    for clip in originals {
        let original = out.last().filter(|o| clip.mirrored && clip.name == format!("{}{}", o.name, mirror::SUFFIX));
        let clip = match original {
            Some(o) => Clip {
                contacts: o.contacts.iter().map(|c| c.mirrored()).collect(),
                excluded: o.excluded.clone(),
                tags: mirror::mirror_tags(&o.tags),
                hits: o.hits.iter().map(mirror::mirror_hit).collect(),
                classes: o.classes.iter().map(mirror::mirror_span).collect(),
                ..clip
            },
            None if clip.mirrored => annotated(&clip)?,
            None => clip,
        };
        out.push(clip);
    }
    hits::set_forces(&mut out);
    Ok(ClipSet { skeleton: clips.skeleton.clone(), clips: out })
}

fn annotate_clip(clip: &Clip, skeleton: &Skeleton, cfg: &AnnotateConfig, sidecars: &Sidecars) -> Result<Clip> {
    let mut out = clip.clone();
    out.contacts = contacts::detect_contacts(clip, skeleton, &cfg.contacts);
    let mut excluded = clip.excluded.clone();
    excluded.extend(ends::find_unusable_ends(clip, skeleton, &cfg.ends));
    let marked = sidecars.annotations_of(clip)?;
    excluded.extend(marked.excluded);
    out.tags.extend(marked.tags);
    out.excluded = disjoint(excluded);
    let hints = NameHints { named: marked.class, ..NameHints::new(&clip.name, &clip.source) };
    out.classes = classes::classify(clip, skeleton, &hints);
    out.hits = hits::find_hits(&out, skeleton, &cfg.hits, &marked.hits, marked.automatic_hits)?;
    Ok(out)
}

/// Sorted by start and without overlaps: where two overlap, the one that starts first keeps the frames.
fn disjoint(mut all: Vec<Exclusion>) -> Vec<Exclusion> {
    all.sort_by_key(|e| (e.range.start, e.range.end));
    ends::cut_overlaps(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clip::ExclusionReason::{Sidecar, Still, TPose};
    use crate::clip::FrameRange;

    #[test]
    fn exclusions_do_not_overlap() {
        let e = |range: FrameRange, reason| Exclusion { range, reason };
        let all = vec![e(5..20, Sidecar), e(0..8, TPose), e(6..7, Still), e(30..31, Still)];
        assert_eq!(disjoint(all), [e(0..8, TPose), e(8..20, Sidecar), e(30..31, Still)]);
    }
}
