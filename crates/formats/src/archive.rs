//! ZIP archives that are recordings: npz of numpy, gt3x of ActiGraph.

use crate::arrays::Arrays;
use crate::names::unpacked_bytes;
use crate::stream::{Contents, Remark, SeekRead};
use crate::{Error, Result, gt3x, npy, zip};

pub(crate) fn read(file: &mut dyn SeekRead, size: u64) -> Result<Contents> {
    let members = zip::members(file, size)?;
    let mut left = unpacked_bytes(size);
    let find = |name: &str| members.iter().find(|m| m.name == name);
    if let (Some(info), Some(data)) = (find("info.txt"), find("log.bin").or(find("activity.bin"))) {
        return gt3x::read(file, info, data, &mut left);
    }
    let mut arrays = Arrays::default();
    let mut any = false;
    for member in members.iter().filter(|m| m.name.ends_with(".npy")) {
        any = true;
        let (content, whole) = member.content(file, &mut left)?;
        let name = member.name.trim_end_matches(".npy");
        match whole {
            true => {
                if let Err(error) = npy::array(content, name, &mut arrays) {
                    let what = format!("{name}: {error}");
                    arrays.remarks.push(Remark::passed_over(what));
                }
            }
            false => {
                let what = format!("{name}, whose check sum does not hold");
                arrays.remarks.push(Remark::damaged(what));
            }
        }
    }
    match any {
        true => Ok(arrays.contents()),
        false => Err(Error::new(format!(
            "is a ZIP archive of {} files, and none of them is a recording that is read in an archive",
            members.len()
        ))
        .with_hint("unpack it, and name the file inside; archives that are read are .npz and .gt3x")),
    }
}
