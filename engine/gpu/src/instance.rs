//! The Vulkan loader and instance, with the validation layer on request.

use std::ffi::{CStr, c_void};
use std::sync::{Arc, OnceLock};

use ash::{ext, khr, vk};

use crate::log::{Message, Severity, ValidationLog};
use crate::result::{Error, Named, Result};

const VALIDATION: &CStr = c"VK_LAYER_KHRONOS_validation";

/// How much the driver's work is checked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Validation {
    /// Not at all.
    #[default]
    Off,
    /// By the validation layer if it is installed.
    IfInstalled,
    /// By the validation layer, synchronization included; without the layer there is no device.
    Required,
}

/// The loader, the instance and its debug messenger.
pub(crate) struct Instance {
    pub(crate) raw: ash::Instance,
    pub(crate) entry: ash::Entry,
    pub(crate) surface: Option<khr::surface::Instance>,
    pub(crate) validated: bool,
    /// Handles can be named and regions of command buffers labelled, for messages and captures.
    pub(crate) labels: bool,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    // The messenger's callback holds a pointer to it: dropped after the instance.
    pub(crate) log: Arc<ValidationLog>,
}

/// The first instance of the process. It is never destroyed, so the loader keeps the drivers loaded. Each load of a driver may take
/// memory that its end does not release. With NVIDIA's driver 580 the loader found no driver any more after some forty devices.
static FIRST: OnceLock<Arc<Instance>> = OnceLock::new();

/// The folders where Homebrew puts the loader. The dynamic linker of macOS does not search them by itself.
const HOMEBREW: [&str; 2] = ["/opt/homebrew/lib/libvulkan.1.dylib", "/usr/local/lib/libvulkan.1.dylib"];

/// The functions of the Vulkan loader.
fn load() -> Result<ash::Entry> {
    // SAFETY: loading the system's Vulkan loader runs its initialisers, as in every Vulkan program.
    let by_name = unsafe { ash::Entry::load() };
    by_name.or_else(|error| {
        let mut others = HOMEBREW.iter().filter(|_| cfg!(target_os = "macos"));
        // SAFETY: as above.
        let found = others.find_map(|path| unsafe { ash::Entry::load_from(path) }.ok());
        found.ok_or_else(|| Error::NoLoader { reason: error.to_string() })
    })
}

impl Instance {
    /// An instance of its own for each caller.
    pub(crate) fn new(validation: Validation) -> Result<Arc<Instance>> {
        let instance = Arc::new(Instance::create(validation)?);
        FIRST.get_or_init(|| instance.clone());
        Ok(instance)
    }

    fn create(validation: Validation) -> Result<Instance> {
        let entry = load()?;
        let log = Arc::new(ValidationLog::default());
        let offered = Offered::of(&entry, validation)?;
        let validated = offered.validated;
        let raw = make(&entry, &offered, &log)?;
        let messenger = (validated && offered.labels()).then(|| messenger(&entry, &raw, &log)).transpose()?;
        let surface = offered.has(khr::surface::NAME).then(|| khr::surface::Instance::new(&entry, &raw));
        Ok(Instance { raw, entry, surface, validated, labels: offered.labels(), messenger, log })
    }
}

/// The offer of the loader and the validation layer.
struct Offered {
    extensions: Vec<vk::ExtensionProperties>,
    /// Of the validation layer, if it is used.
    extensions_of_layer: Vec<vk::ExtensionProperties>,
    /// The validation layer is used.
    validated: bool,
}

impl Offered {
    fn of(entry: &ash::Entry, validation: Validation) -> Result<Self> {
        // SAFETY: plain queries, no handle is involved.
        let layers =
            unsafe { entry.enumerate_instance_layer_properties() }.named("vkEnumerateInstanceLayerProperties")?;
        let installed = layers.iter().any(|layer| layer.layer_name_as_c_str() == Ok(VALIDATION));
        let validated = match validation {
            Validation::Off => false,
            Validation::IfInstalled => installed,
            Validation::Required if !installed => return Err(Error::NoValidationLayer),
            Validation::Required => true,
        };
        // SAFETY: as above.
        let extensions = unsafe { entry.enumerate_instance_extension_properties(None) }
            .named("vkEnumerateInstanceExtensionProperties")?;
        // SAFETY: as above; the layer was listed.
        let extensions_of_layer = validated
            .then(|| unsafe { entry.enumerate_instance_extension_properties(Some(VALIDATION)) })
            .transpose()
            .named("vkEnumerateInstanceExtensionProperties")?
            .unwrap_or_default();
        Ok(Self { extensions, extensions_of_layer, validated })
    }

    fn has(&self, name: &CStr) -> bool {
        self.extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(name))
    }

    fn layer_has(&self, name: &CStr) -> bool {
        self.extensions_of_layer.iter().any(|e| e.extension_name_as_c_str() == Ok(name))
    }

    /// Handles can be named.
    fn labels(&self) -> bool {
        self.has(ext::debug_utils::NAME) || self.layer_has(ext::debug_utils::NAME)
    }

    /// MoltenVK is only listed with portability enumeration. Untested: no machine with it was at hand.
    fn portability(&self) -> bool {
        self.has(khr::portability_enumeration::NAME)
    }

    /// The extension that configures the checks of the validation layer.
    fn settings(&self) -> Option<&'static CStr> {
        let known = [ext::layer_settings::NAME, ext::validation_features::NAME];
        known.into_iter().find(|name| self.validated && self.layer_has(name))
    }

    /// The extensions that raxel enables.
    fn enabled(&self) -> Vec<&'static CStr> {
        // Surfaces of every window system that is there: the instance is made before anybody knows whether a window will come.
        let windowing = [
            khr::surface::NAME,
            khr::xlib_surface::NAME,
            khr::xcb_surface::NAME,
            khr::wayland_surface::NAME,
            khr::win32_surface::NAME,
            ext::metal_surface::NAME,
        ];
        // On systems without Wayland, a request for it makes Mesa's device-selection layer complain on stderr.
        let wayland = ["WAYLAND_DISPLAY", "WAYLAND_SOCKET"].iter().any(|name| std::env::var_os(name).is_some());
        let usable = |name: &CStr| self.has(name) && (wayland || name != khr::wayland_surface::NAME);
        let labels = self.labels().then_some(ext::debug_utils::NAME);
        let portability = self.portability().then_some(khr::portability_enumeration::NAME);
        windowing
            .into_iter()
            .filter(|name| usable(name))
            .chain(labels)
            .chain(portability)
            .chain(self.settings())
            .collect()
    }
}

fn make(entry: &ash::Entry, offered: &Offered, log: &Arc<ValidationLog>) -> Result<ash::Instance> {
    let extensions: Vec<_> = offered.enabled().into_iter().map(CStr::as_ptr).collect();
    let layers: Vec<_> = offered.validated.then_some(VALIDATION.as_ptr()).into_iter().collect();
    let application = vk::ApplicationInfo::default()
        .application_name(c"raxel")
        .engine_name(c"raxel")
        .api_version(vk::API_VERSION_1_3);
    let mut messenger_info = messenger_info(log);
    let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
    let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
    let on = vk::TRUE.to_ne_bytes();
    let setting = |name| {
        vk::LayerSettingEXT::default()
            .layer_name(VALIDATION)
            .setting_name(name)
            .ty(vk::LayerSettingTypeEXT::BOOL32)
            .values(&on)
    };
    // Since 1.3.290 synchronization validation looks at shader accesses only on request.
    let settings = [setting(c"validate_sync"), setting(c"syncval_shader_accesses_heuristic")];
    let mut settings = vk::LayerSettingsCreateInfoEXT::default().settings(&settings);
    let mut info = vk::InstanceCreateInfo::default()
        .application_info(&application)
        .enabled_layer_names(&layers)
        .enabled_extension_names(&extensions);
    if offered.portability() {
        info = info.flags(vk::InstanceCreateFlags::ENUMERATE_PORTABILITY_KHR);
    }
    if offered.validated && offered.labels() {
        info = info.push_next(&mut messenger_info);
    }
    info = match offered.settings() {
        Some(name) if name == ext::layer_settings::NAME => info.push_next(&mut settings),
        Some(_) => info.push_next(&mut features),
        None => info,
    };
    // SAFETY: everything `info` points to lives until the call returns; the caller keeps `log` as long as the instance.
    match unsafe { entry.create_instance(&info, None) } {
        Ok(raw) => Ok(raw),
        Err(vk::Result::ERROR_INCOMPATIBLE_DRIVER) => Err(Error::NoDriver { candidates: Vec::new() }),
        Err(result) => Err(Error::Vulkan { call: "vkCreateInstance", result }),
    }
}

/// Brings the messages of the validation layer to the log. If that fails, the instance is destroyed.
fn messenger(
    entry: &ash::Entry,
    raw: &ash::Instance,
    log: &Arc<ValidationLog>,
) -> Result<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)> {
    let functions = ext::debug_utils::Instance::new(entry, raw);
    // SAFETY: the callback's user pointer is `log`, which outlives the messenger (field order and `Drop` of `Instance`).
    match unsafe { functions.create_debug_utils_messenger(&messenger_info(log), None) } {
        Ok(messenger) => Ok((functions, messenger)),
        Err(result) => {
            // SAFETY: the instance was just made and has no children.
            unsafe { raw.destroy_instance(None) };
            Err(Error::Vulkan { call: "vkCreateDebugUtilsMessengerEXT", result })
        }
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: devices and surfaces hold an `Arc` of the instance, so none is left.
        unsafe {
            if let Some((functions, messenger)) = self.messenger.take() {
                functions.destroy_debug_utils_messenger(messenger, None);
            }
            self.raw.destroy_instance(None);
        }
    }
}

fn messenger_info(log: &Arc<ValidationLog>) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
    vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(vk::DebugUtilsMessageSeverityFlagsEXT::WARNING | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR)
        // No performance advice: images stay in `GENERAL` on purpose, and the layer would warn at every copy.
        .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION)
        .pfn_user_callback(Some(on_message))
        .user_data(Arc::as_ptr(log).cast_mut().cast())
}

unsafe extern "system" fn on_message(
    severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    log: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: Vulkan passes valid data for the time of the call, and `log` is the pointer given at creation.
    let (data, log) = unsafe { (data.as_ref(), log.cast::<ValidationLog>().as_ref()) };
    if let (Some(data), Some(log)) = (data, log) {
        // SAFETY: both are null or NUL-terminated and live for the time of the call.
        let (id, text) = unsafe { (data.message_id_name_as_c_str(), data.message_as_c_str()) };
        let text_of = |text: Option<&CStr>| text.map(|t| t.to_string_lossy().into_owned()).unwrap_or_default();
        let severity = if severity.contains(vk::DebugUtilsMessageSeverityFlagsEXT::ERROR) {
            Severity::Error
        } else {
            Severity::Warning
        };
        log.push(Message { severity, id: text_of(id), text: text_of(text) });
    }
    vk::FALSE
}
