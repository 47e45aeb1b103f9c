// What static libraries within the wheel write to where they find something wrong. They reach for
// the variable of the C library in a way that only the program itself may; here it is one of the
// extension's own.
extern "C" {

extern char _IO_2_1_stderr_[];  // the file of glibc
[[gnu::visibility("hidden")]] void* stderr = _IO_2_1_stderr_;

}  // extern "C"
