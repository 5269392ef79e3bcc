//! What the fuzz targets and their seeds have in common.

pub mod bundle;

/// Parts the two files of an `amc` input: the ASF skeleton before it, the AMC motion after it.
pub const ASF_AMC_SEAM: &[u8] = b"#--amc--\n";
