//! What a desktop's session would give the process, and a server's does not.

/// Keeps the Wayland library from complaining on standard error where there is no session.
///
/// Mesa's Vulkan layer for choosing a device asks Wayland for one, because wgpu enables Wayland's
/// surfaces; without `XDG_RUNTIME_DIR` the library says so, each time. The layer is not needed, as
/// adapters are chosen by their kind, but only the environment that a process starts with turns it
/// off: so the program starts itself anew, as the same process, before it has done anything.
#[cfg(unix)]
pub fn leave_wayland_alone() {
    use std::env;
    use std::os::unix::process::CommandExt;
    use std::path::Path;
    use std::process::Command;

    const TURNED_OFF: &str = "NODEVICE_SELECT";
    let has_session =
        env::var_os("XDG_RUNTIME_DIR").is_some_and(|place| Path::new(&place).is_absolute());
    if has_session || env::var_os(TURNED_OFF).is_some() {
        return;
    }
    let Ok(program) = env::current_exe() else { return };
    let mut arguments = env::args_os();
    let mut anew = Command::new(program);
    anew.env(TURNED_OFF, "1").arg0(arguments.next().unwrap_or_default()).args(arguments);
    // It returns only where it failed: then the complaint is the smaller evil.
    let _ = anew.exec();
}

/// There is no Wayland.
#[cfg(not(unix))]
pub fn leave_wayland_alone() {}
