//! Scene files of before there was one format: refused, with the new place of each key.

use throng_base::Result;
use throng_base::text::Source;
use toml::de::DeValue;

/// Keys that stood at the top of a file, and where they stand now.
pub(super) const MOVED: [(&str, &str); 23] = [
    ("kind", "`motion = \"sparring\"` (pairs) or `motion = \"policy\"` (targets) in `[[groups]]`"),
    ("characters", "`count` in `[[groups]]`"),
    ("spacing_m", "`place = { grid = { spacing_m = .. } }` in `[[groups]]`"),
    ("distance_m", "`place = { grid = { distance_m = .. } }` in `[[groups]]`"),
    ("temperature", "`temperature` in `[[groups]]`"),
    ("goals", "`[[groups.behaviours]]`, with `name` in place of `behaviour`"),
    ("target", "`[groups.target]`"),
    ("world", "`world_config` in `[environment]`, beside `world`, the stitched file, and `bundle` at the top"),
    ("wishes", "`[[groups.wishes]]` of a group with `motion = \"patches\"`"),
    ("spaces", "`spaces` in `[[groups]]` with `motion = \"blend\"`"),
    ("paths", "`[groups.paths]` of a group with `motion = \"blend\"`"),
    ("style_by_speed", "`style_by_speed` in `[[groups]]`"),
    ("bodies", "`[groups.bodies]`; its `bundle` and `config` stand at the top, its `spaces` in `[[groups]]`"),
    ("hills_m", "`hills_m` in `[environment]`"),
    ("shown", "`[[picture.shown]]`"),
    ("obstacles", "`[[environment.obstacles]]`"),
    ("space", "`space` in `[environment]`"),
    ("gate", "`gate` in `[measure]`"),
    ("lanes", "`[measure.lanes]`"),
    ("grows", "`grows` in `[measure]`"),
    ("engine", "`engine` in `[agents]`"),
    ("routes", "`routes` in `[agents]`"),
    ("field", "`[agents.field]`"),
];

/// Refuses what no scene file has any more.
pub(super) fn refuse(source: &Source) -> Result<()> {
    let Some(table) = source.table() else { return Ok(()) };
    // In the order of the file: the table itself is sorted by name.
    let mut keys: Vec<_> = table.iter().collect();
    keys.sort_by_key(|(key, _)| key.span().start);
    if let Some((key, _)) = keys.iter().find(|(key, _)| key.get_ref() == "tasks") {
        let why = "`tasks` makes this a file of tasks, not a scene: run `throng plan` on it";
        return Err(source.error(key.span(), why.into()));
    }
    for (key, value) in keys {
        let name = key.get_ref().as_ref();
        if let Some((_, now)) = MOVED.iter().find(|m| m.0 == name) {
            return Err(source.error(key.span(), format!("`{name}` is a key of older scene files: write {now}")));
        }
        if let ("groups", DeValue::Array(groups)) = (name, value.get_ref()) {
            for group in groups.iter() {
                let DeValue::Table(keys) = group.get_ref() else { continue };
                if !keys.keys().any(|k| k.get_ref() == "motion") {
                    let why = "a group says what moves it: add `motion = \"none\"` for agents without bodies, \
                               or \"policy\", \"blend\", \"patches\" or \"sparring\"";
                    return Err(source.error(group.span(), why.into()));
                }
            }
        }
    }
    Ok(())
}
