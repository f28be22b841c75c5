//! HDF5, and MAT of version 7.3, which is HDF5 behind 512 bytes of MATLAB: superblocks 0 to 3, groups and links of every age,
//! datasets in one piece and in chunks under every index.
//!
//! **Source** `[HDF5]`.

mod chunked;
mod dataset;
mod datatype;
mod file;
mod filters;
mod group;
mod header;
mod heap;
mod index;
mod layout;

use crate::Result;
use crate::arrays::Arrays;
use crate::names::shown;
use crate::stream::{Contents, Remark, SeekRead};
use file::File;
use header::{Header, has_attribute, kind};
use std::collections::HashSet;

pub(crate) use chunked::{Chunked, Unpacked};
pub(crate) use file::{is_hdf5, is_mat73};

/// Groups within groups.
const DEEPEST: usize = 64;

pub(crate) fn read(file: &mut dyn SeekRead, size: u64) -> Result<Contents> {
    walk(file, size, false)
}

/// MAT of version 7.3.
pub(crate) fn read_mat(file: &mut dyn SeekRead, size: u64) -> Result<Contents> {
    walk(file, size, true)
}

/// An object that is still to be looked at.
struct Object {
    name: String,
    at: u64,
    depth: usize,
}

fn walk(file: &mut dyn SeekRead, size: u64, matlab: bool) -> Result<Contents> {
    let (mut file, root, end) =
        File::of(file, size).map_err(|t| t.error("the head of the file", size))?;
    let header = file
        .header(root)
        .map_err(|t| t.error("the list of datasets", size))?;
    let mut arrays = Arrays::default();
    if end > size {
        arrays.remarks.push(Remark::cut(format!(
            "the file ends at byte {size} and states {end} bytes"
        )));
    }
    let mut ahead = Vec::new();
    let first = Object {
        name: String::new(),
        at: root,
        depth: 0,
    };
    let found = children(&mut file, &header, &first, matlab, &mut ahead, &mut arrays);
    if let Err(trouble) = found {
        // Without a single name there is nothing to go on with.
        if ahead.is_empty() {
            return Err(trouble.error("the list of datasets", size));
        }
        arrays
            .remarks
            .push(trouble.remark("the list of datasets", size)?);
    }
    let mut seen = HashSet::from([root]);
    while let Some(object) = ahead.pop() {
        if !seen.insert(object.at) {
            continue;
        }
        let taken = take(&mut file, &object, matlab, &mut ahead, &mut arrays);
        if let Err(trouble) = taken {
            arrays.remarks.push(trouble.remark(&object.name, size)?);
        }
    }
    Ok(arrays.contents())
}

/// Takes in an object: the children of a group, the channels of a dataset.
fn take(
    file: &mut File<'_>,
    object: &Object,
    matlab: bool,
    ahead: &mut Vec<Object>,
    arrays: &mut Arrays,
) -> file::Found<()> {
    let header = file.header(object.at)?;
    let class = match matlab {
        true => file.text_of(&header, &["matlab_class"])?,
        false => None,
    };
    let foreign = |what: &str| Err(file::Trouble::Foreign(what.to_owned()));
    if group::is_group(&header) {
        return match object.depth {
            _ if matlab && has_attribute(&header, "MATLAB_sparse") => foreign("a sparse matrix"),
            DEEPEST.. => foreign("groups within groups"),
            _ => children(file, &header, object, matlab, ahead, arrays),
        };
    }
    if !header.has(kind::LAYOUT) {
        return Ok(());
    }
    match class.as_deref() {
        // Texts are no samples, and may say who measured.
        Some("char") => Ok(()),
        Some("cell") => foreign("cells"),
        Some(
            "double" | "single" | "logical" | "int8" | "uint8" | "int16" | "uint16" | "int32"
            | "uint32" | "int64" | "uint64",
        )
        | None => match matlab && has_attribute(&header, "MATLAB_empty") {
            true => Ok(()),
            false => file.dataset(&header, &object.name, matlab, arrays),
        },
        Some(_) => foreign("an object"),
    }
}

/// Puts the children of a group before all others, in their order.
fn children(
    file: &mut File<'_>,
    header: &Header,
    object: &Object,
    matlab: bool,
    ahead: &mut Vec<Object>,
    arrays: &mut Arrays,
) -> file::Found<()> {
    let mut links = Vec::new();
    let found = file.links(header, &mut links);
    for link in links.into_iter().rev() {
        // What MATLAB keeps for itself.
        if matlab && object.depth == 0 && link.name.starts_with('#') {
            continue;
        }
        let name = match (object.name.is_empty(), matlab) {
            (true, _) => link.name,
            (false, true) => format!("{}.{}", object.name, link.name),
            (false, false) => format!("{}/{}", object.name, link.name),
        };
        let name = shown(&name);
        match link.at {
            Some(at) => ahead.push(Object {
                name,
                at,
                depth: object.depth + 1,
            }),
            None if link.outside => {
                arrays.remarks.push(Remark::passed_over(format!(
                    "{name}, which stands in another file"
                )));
            }
            None => {}
        }
    }
    found
}

#[cfg(test)]
mod tests;
