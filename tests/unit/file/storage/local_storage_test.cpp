// The real file system: what it does, and what becomes of every call that fails.
#include <gtest/gtest.h>

#include <sys/file.h>
#include <sys/stat.h>
#include <sys/xattr.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <functional>

#include "octavo/core/error.h"
#include "octavo/file/storage/storage.h"
#include "octavo/file/storage/temporary.h"
#include "support/failing_system.h"

namespace octavo {
namespace {

namespace fs = std::filesystem;
using testing::end_faults;
using testing::set_faults;
using testing::SystemFaults;
using Bytes = std::vector<std::uint8_t>;

const Bytes kTen = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};

class LocalStorage : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_NE(::mkdtemp(folder_.data()), nullptr); }
  void TearDown() override {
    end_faults();
    fs::remove_all(folder_);
  }

  std::string path(const std::string& name) const { return folder_ + "/" + name; }
  std::string text_of(const std::string& name) const {
    std::ifstream in(path(name));
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void write_text(const std::string& name, const std::string& text = "text") const {
    std::ofstream(path(name)) << text;
  }
  std::unique_ptr<StorageFile> new_file(const std::string& name) const {
    auto file = storage_.create_exclusive(path(name));
    file->write(0, kTen);
    return file;
  }

  Storage& storage_ = local_storage();
  std::string folder_ = "/tmp/octavo-local-XXXXXX";
};

/// The Error{io} that `work` throws while call `number` of a kind fails.
std::string message_of(const SystemFaults& faults, const std::function<void()>& work) {
  set_faults(faults);
  std::string message;
  try {
    work();
  } catch (const Error& error) {
    message = error.what();
    EXPECT_EQ(error.kind(), ErrorKind::io) << message;
  }
  end_faults();
  return message;
}

TEST_F(LocalStorage, ReadsExactlyOrTellsWhereTheFileEnds) {
  const auto file = new_file("a");
  Bytes out(4);
  file->read(6, out);
  EXPECT_EQ(out, (Bytes{6, 7, 8, 9}));
  try {
    file->read(7, out);
    ADD_FAILURE() << "read beyond the end";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::truncated);
    EXPECT_EQ(error.offset(), 10u);
    EXPECT_STREQ(error.what(), (path("a") + ": ends at byte 10, 1 bytes too early").c_str());
  }
}

TEST_F(LocalStorage, TruncateCutsAndNeverGrows) {
  const auto file = new_file("a");
  file->truncate(12);
  EXPECT_EQ(file->size(), 10u);
  file->truncate(4);
  EXPECT_EQ(file->size(), 4u);
  file->truncate(9);
  EXPECT_EQ(file->size(), 4u);
  file->close();
  file->close();
  EXPECT_EQ(text_of("a"), std::string("\0\1\2\3", 4));
}

TEST_F(LocalStorage, TellsFilesFoldersAndOthersApart) {
  write_text("file");
  fs::create_directory(path("folder"));
  fs::create_symlink("file", path("link"));
  fs::create_symlink("nowhere", path("dangling"));
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  const struct {
    const char* name;
    PathType type;
    bool exists;
  } cases[] = {{"file", PathType::file, true},       {"folder", PathType::folder, true},
               {"link", PathType::file, true},       {"dangling", PathType::other, true},
               {"pipe", PathType::other, true},      {"none", PathType::missing, false},
               {"file/below", PathType::missing, false}};
  for (const auto& c : cases) {
    EXPECT_EQ(storage_.path_type(path(c.name)), c.type) << c.name;
    EXPECT_EQ(storage_.exists(path(c.name)), c.exists) << c.name;
  }
  const std::string too_long = path(std::string(300, 'n'));
  EXPECT_THROW(storage_.exists(too_long), Error);
  EXPECT_THROW(storage_.path_type(too_long), Error);
}

TEST_F(LocalStorage, OnlyAFreeRegularFileIsOpenedForUpdate) {
  write_text("file");
  fs::create_directory(path("folder"));
  fs::create_symlink("file", path("link"));
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  for (const char* name : {"none", "folder", "link", "pipe"}) {
    EXPECT_EQ(storage_.open_update(path(name)), nullptr) << name;
  }
  auto held = storage_.open_update(path("file"));
  ASSERT_NE(held, nullptr);
  EXPECT_EQ(storage_.open_update(path("file")), nullptr);
  held.reset();
  EXPECT_NE(storage_.open_update(path("file")), nullptr);
  // Somebody removes it between its opening and its locking.
  SystemFaults faults;
  faults.call = "flock";
  faults.before = [&](std::uint64_t) { fs::remove(path("file")); };
  set_faults(faults);
  EXPECT_EQ(storage_.open_update(path("file")), nullptr);
}

TEST_F(LocalStorage, ANewNameDoesNotReplaceAnother) {
  // On file systems with and without the call that does it in one step.
  for (const int code : {0, EINVAL, ENOSYS}) {
    write_text("from");
    write_text("to", "old");
    const SystemFaults faults{"rename", 1, code};
    const auto rename = [&] { storage_.rename_new(path("from"), path("to")); };
    EXPECT_EQ(message_of(faults, rename), path("to") + ": exists already");
    EXPECT_EQ(text_of("to"), "old");
    fs::remove(path("to"));
    EXPECT_EQ(message_of(faults, rename), "");
    EXPECT_EQ(text_of("to"), "text");
    EXPECT_FALSE(storage_.exists(path("from")));
    EXPECT_NE(message_of({}, rename), "");
  }
}

TEST_F(LocalStorage, TwoNamesChangePlacesOrNothingHappens) {
  write_text("a", "1");
  write_text("b", "2");
  EXPECT_TRUE(storage_.exchange(path("a"), path("b")));
  EXPECT_EQ(text_of("a") + text_of("b"), "21");
  for (const int code : {EINVAL, ENOSYS}) {
    set_faults({"rename", 1, code});
    EXPECT_FALSE(storage_.exchange(path("a"), path("b")));
    end_faults();
  }
  EXPECT_THROW(storage_.exchange(path("a"), path("none")), Error);
  EXPECT_EQ(text_of("a") + text_of("b"), "21");
}

TEST_F(LocalStorage, AScratchFileHasNoName) {
  // The first open is that of a nameless file, which some file systems do not have.
  for (const int code : {0, EOPNOTSUPP}) {
    set_faults({"open", 1, code});
    const auto file = storage_.create_scratch(folder_);
    end_faults();
    file->write(0, kTen);
    Bytes out(10);
    file->read(0, out);
    EXPECT_EQ(out, kTen);
    EXPECT_TRUE(fs::is_empty(folder_));
  }
  EXPECT_THROW(storage_.create_scratch(path("none")), Error);
}

TEST_F(LocalStorage, SaysWhyAFolderTakesNoFilesAndLeavesNothingInOthers) {
  EXPECT_EQ(storage_.why_closed(folder_), "");
  // By a file that has a name for a moment.
  std::string why = "not asked";
  const SystemFaults nameless{"open", 1, EOPNOTSUPP};
  EXPECT_EQ(message_of(nameless, [&] { why = storage_.why_closed(folder_); }), "");
  EXPECT_EQ(why, "");
  EXPECT_EQ(storage_.list(path("")).size(), 0u);
  EXPECT_EQ(storage_.why_closed(path("none")), "No such file or directory");
}

TEST_F(LocalStorage, ListsWhatBeginsWithAPrefix) {
  write_text("b2");
  write_text("b1");
  write_text("a");
  EXPECT_EQ(storage_.list(path("b")), (std::vector<std::string>{path("b1"), path("b2")}));
  EXPECT_EQ(storage_.list(path("")).size(), 3u);
  EXPECT_TRUE(storage_.list(path("none/b")).empty());
  EXPECT_TRUE(storage_.list(path("a/b")).empty());
  EXPECT_THROW(storage_.list(path(std::string(300, 'n') + "/b")), Error);
}

TEST_F(LocalStorage, WhatIsTakenAwayWhileItIsMadeIsMadeAgain) {
  SystemFaults faults;
  faults.call = "flock";
  const auto remove = [&](std::uint64_t) { fs::remove(path("a")); };
  faults.before = [&](std::uint64_t number) {
    if (number == 1) remove(number);
  };
  EXPECT_EQ(message_of(faults, [&] { storage_.create_exclusive(path("a")); }), "");
  EXPECT_EQ(storage_.path_type(path("a")), PathType::file);
  fs::remove(path("a"));
  EXPECT_EQ(message_of(faults, [&] { storage_.create_folder(path("a"), ""); }), "");
  EXPECT_EQ(storage_.path_type(path("a")), PathType::folder);
  fs::remove(path("a"));
  faults.before = remove;
  for (const bool is_folder : {false, true}) {
    const std::string message = message_of(faults, [&] {
      is_folder ? storage_.create_folder(path("a"), "") : storage_.create_exclusive(path("a"));
    });
    EXPECT_NE(message.find("removes it again and again"), std::string::npos) << message;
    EXPECT_TRUE(fs::is_empty(folder_));
  }
}

TEST_F(LocalStorage, LocksAreWaitedForAndDoneWithout) {
  // Somebody looks at the new file just then; a file system that has no locks.
  for (const int code : {EWOULDBLOCK, ENOLCK}) {
    const std::string name = "a" + std::to_string(code);
    EXPECT_EQ(message_of({"flock", 1, code}, [&] { new_file(name); }), "");
    EXPECT_EQ(text_of(name).size(), 10u);
    set_faults({"flock", 1, code});
    EXPECT_EQ(storage_.open_update(path(name)), nullptr);
    end_faults();
  }
}

TEST_F(LocalStorage, AFileSystemWithoutLocksIsToldFromAFileThatIsLocked) {
  write_text("a");
  EXPECT_TRUE(storage_.has_locks(path("a")));
  EXPECT_TRUE(storage_.has_locks(folder_));
  for (const int code : {ENOSYS, ENOTSUP, ENOLCK, EINVAL}) {
    set_faults({.call = "flock", .code = code, .always = true});
    EXPECT_FALSE(storage_.has_locks(path("a"))) << code;
    EXPECT_FALSE(storage_.has_locks(folder_)) << code;
    EXPECT_EQ(storage_.lock_left(path("a")), nullptr) << code;
    end_faults();
  }
  const auto held = storage_.lock_left(path("a"));
  ASSERT_NE(held, nullptr);
  EXPECT_TRUE(storage_.has_locks(path("a")));
  EXPECT_EQ(storage_.lock_left(path("a")), nullptr);
}

TEST_F(LocalStorage, EveryFailingCallIsReportedWithItsPath) {
  write_text("a");
  const auto file = new_file("open");
  const struct {
    const char* call;
    std::function<void()> work;
  } cases[] = {
      {"fstat", [&] { file->size(); }},
      {"fstat", [&] { storage_.open_read(path("a")); }},
      {"fstat", [&] { storage_.open_update(path("a")); }},
      {"fstat", [&] { storage_.create_exclusive(path("new")); }},
      {"lstat", [&] { storage_.create_exclusive(path("newer")); }},
      {"lstat", [&] { storage_.exists(path("a")); }},
      {"stat", [&] { storage_.path_type(path("a")); }},
      {"open", [&] { storage_.open_read(path("a")); }},
      {"open", [&] { storage_.open_update(path("a")); }},
      {"open", [&] { storage_.create_folder(path("folder"), ""); }},
      {"open", [&] { storage_.sync_folder(folder_); }},
      {"fsync", [&] { storage_.sync_folder(folder_); }},
      {"fsync", [&] { file->sync(); }},
      {"pread",
       [&] {
         Bytes out(1);
         file->read(0, out);
       }},
      {"pwrite", [&] { file->write(0, kTen); }},
      {"ftruncate", [&] { file->truncate(1); }},
      {"unlink", [&] { storage_.remove(path("a")); }},
      {"mkdir", [&] { storage_.create_folder(path("other"), ""); }},
      {"rename", [&] { storage_.rename(path("a"), path("b")); }},
      {"rename", [&] { storage_.rename_new(path("a"), path("b")); }},
      {"rename", [&] { storage_.exchange(path("a"), path("b")); }},
  };
  for (const auto& c : cases) {
    const std::string message = message_of({c.call, 1, EIO}, c.work);
    EXPECT_EQ(message.find(folder_), 0u) << c.call << ": " << message;
    EXPECT_NE(message.find(": Input/output error"), std::string::npos) << message;
  }
  EXPECT_EQ(text_of("a"), "text");
  EXPECT_EQ(file->size(), 10u);
  // A full disk says how much is needed and how much is free.
  const SystemFaults full[] = {{"pwrite", 1, ENOSPC}, {"fsync", 1, ENOSPC}, {"fsync", 1, EDQUOT}};
  for (const SystemFaults& faults : full) {
    const std::string message = message_of(faults, [&] {
      file->write(0, kTen);
      file->sync();
    });
    const bool is_write = std::string_view(faults.call) == "pwrite";
    const std::string needed = is_write ? ": 10 bytes more needed, " : ", ";
    EXPECT_NE(message.find("no space left" + needed), std::string::npos) << message;
    EXPECT_TRUE(message.ends_with(" MiB free")) << message;
  }
  // A named scratch file that keeps its name would be left behind.
  SystemFaults faults{"open", 1, EOPNOTSUPP};
  faults.before = [](std::uint64_t) { set_faults({"unlink", 1, EIO}); };
  EXPECT_NE(message_of(faults, [&] { storage_.create_scratch(folder_); }).find("scratch"),
            std::string::npos);
  // Removing what is gone, and syncing where folders cannot be synced, are no failures.
  storage_.remove(path("none"));
  for (const int code : {EINVAL, ENOTSUP}) {
    EXPECT_EQ(message_of({"fsync", 1, code}, [&] { storage_.sync_folder(folder_); }), "");
  }
  EXPECT_THROW(storage_.sync_folder(path("none")), Error);
}

TEST_F(LocalStorage, WhatNobodyHasLockedIsRemovedWhateverProcessHasItsNumber) {
  // In a container every program is process 1.
  const std::string numbers[] = {"1", std::to_string(::getpid()), "2147483647"};
  for (const std::string& number : numbers) {
    const std::string left = ".a.tmp-" + number;
    for (const char* ending : {"", "-1", "-2", "-2.journal", "-3.journal", "-4", "-4.journal"}) {
      write_text(left + ending);
    }
    const auto held = storage_.open_update(path(left + "-1"));
    const auto held_journal = storage_.open_update(path(left + "-2.journal"));
    const auto held_file = storage_.open_update(path(left + "-4"));
    storage_.remove_stale(path(".a.tmp-"));
    for (const char* ending : {"", "-3.journal"}) {
      EXPECT_FALSE(storage_.exists(path(left + ending))) << left << ending;
    }
    // Of a build that runs, both the growing file and its journal stay.
    for (const char* ending : {"-1", "-2", "-2.journal", "-4", "-4.journal"}) {
      EXPECT_TRUE(storage_.exists(path(left + ending))) << left << ending;
    }
  }
  storage_.remove_stale(path(".a.tmp-"));
  EXPECT_TRUE(fs::is_empty(folder_));
  storage_.remove_stale(path("none/.a.tmp-"));
}

TEST_F(LocalStorage, WhatWasNotMadeHereIsNeverRemoved) {
  const char* const files[] = {
      ".a.tmp-",          ".a.tmp-x",        ".a.tmp-0",          ".a.tmp--5",
      ".a.tmp-9.bak",     ".a.tmp-9-",       ".a.tmp-9-x",        ".a.tmp-9-100",
      ".a.tmp-9.8vo",     ".a.tmp-09",       ".a.tmp-9.journal2", ".a.tmp-9.8vo.tmp-9",
      ".a.tmp-9journal",  ".a.tmp-9 (copy)", ".b.tmp-9",          ".a.tmp-99999999999",
      ".a.tmp-9.journal~"};
  for (const char* name : files) write_text(name);
  fs::create_symlink("nowhere", path(".a.tmp-9-1"));
  ASSERT_EQ(::mkfifo(path(".a.tmp-9-2").c_str(), 0600), 0);
  // Folders that hold anything but planes: by another name, deeper, or called a plane.
  const char* const kept[] = {".a.tmp-9-3/notes.txt", ".a.tmp-9-4/plane_0000.tif/inside",
                              ".a.tmp-9-5/plane_1.tif", ".a.tmp-9-saved/plane_0000.tif"};
  for (const char* name : kept) {
    fs::create_directories(fs::path(path(name)).parent_path());
    write_text(name);
    write_text(fs::path(name).begin()->string() + "/plane_0007.tif");
  }
  // And one that is a stack that was left behind.
  fs::create_directory(path(".a.tmp-9"));
  write_text(".a.tmp-9/plane_0000.tif");
  write_text(".a.tmp-9/plane_10000.tif");

  storage_.remove_stale(path(".a.tmp-"));
  EXPECT_FALSE(storage_.exists(path(".a.tmp-9")));
  for (const char* name : files) EXPECT_TRUE(storage_.exists(path(name))) << name;
  for (const char* name : {".a.tmp-9-1", ".a.tmp-9-2"}) {
    EXPECT_TRUE(storage_.exists(path(name))) << name;
  }
  for (const char* name : kept) {
    EXPECT_TRUE(storage_.exists(path(name))) << name;
    EXPECT_TRUE(storage_.exists(path(fs::path(name).begin()->string() + "/plane_0007.tif")));
  }
}

TEST_F(LocalStorage, WithoutLocksNothingCountsAsLeftBehind) {
  write_text(".a.tmp-2147483647");
  for (const int code : {ENOLCK, ENOTSUP}) {
    set_faults({"flock", 1, code});
    storage_.remove_stale(path(".a.tmp-"));
    end_faults();
    EXPECT_TRUE(storage_.exists(path(".a.tmp-2147483647"))) << code;
  }
}

TEST_F(LocalStorage, AClosedFileIsLockedUntilItIsLetGo) {
  auto file = new_file(".a.tmp-9");
  file->close();
  storage_.remove_stale(path(".a.tmp-"));
  EXPECT_TRUE(storage_.exists(path(".a.tmp-9")));
  file.reset();
  storage_.remove_stale(path(".a.tmp-"));
  EXPECT_FALSE(storage_.exists(path(".a.tmp-9")));
}

TEST_F(LocalStorage, ANameThatNobodyCanTakeIsToldWithWhatStandsInItsWay) {
  const std::string number = std::to_string(::getpid());
  fs::create_symlink("nowhere", path(".a.tmp-" + number));
  for (int i = 1; i < 100; ++i) {
    fs::create_symlink("nowhere", path(".a.tmp-" + number + "-" + std::to_string(i)));
  }
  const std::string message = message_of({}, [&] { create_temporary(storage_, path("a")); });
  EXPECT_EQ(message.find(path("a") + ": unfinished files of it lie beside it, .a.tmp-*"), 0u)
      << message;
}

/// The permission bits of what a name stands for.
mode_t mode_of(const std::string& path) {
  struct stat status {};
  EXPECT_EQ(::stat(path.c_str(), &status), 0) << path;
  return status.st_mode & 07777;
}

TEST_F(LocalStorage, WhatTakesAnothersPlaceIsOpenToNobodyElse) {
  const mode_t before = ::umask(022);
  write_text("file");
  fs::create_directory(path("folder"));
  fs::create_symlink("file", path("link"));
  int number = 0;
  for (const mode_t mode : {0600u, 0640u, 0644u, 0604u, 0666u, 0400u, 04755u}) {
    ASSERT_EQ(::chmod(path("file").c_str(), mode), 0);
    ASSERT_EQ(::chmod(path("folder").c_str(), mode), 0);
    for (const char* target : {"file", "link"}) {
      const std::string made = path("made" + std::to_string(++number));
      const auto file = storage_.create_replacement(made, path(target));
      EXPECT_EQ(mode_of(made), (mode & 0777) | 0600) << target;
    }
    const std::string made = path("made" + std::to_string(++number));
    const auto folder = storage_.create_folder(made, path("folder"));
    EXPECT_EQ(mode_of(made), (mode & 0777) | 0700);
  }
  // Where nothing of its kind stands, the umask decides.
  storage_.create_replacement(path("new"), path("none"));
  storage_.create_replacement(path("newer"), path("folder"));
  storage_.create_folder(path("newest"), path("file"));
  EXPECT_EQ(mode_of(path("new")), 0644u);
  EXPECT_EQ(mode_of(path("newer")), 0644u);
  EXPECT_EQ(mode_of(path("newest")), 0755u);
  ::umask(before);
}

// The group's permissions of a file with a list are the most that anybody in the list has.
TEST_F(LocalStorage, WhereAListSaysWhoReadsNobodyGainsByItsLoss) {
  write_text("file");
  struct Entry {
    std::uint16_t tag;
    std::uint16_t permissions;
    std::uint32_t id;
  };
  constexpr std::uint32_t kNobody = ~std::uint32_t{0};
  // Owner rw, user 1 rw, group none, mask rw, others none.
  const struct {
    std::uint32_t version;
    Entry entries[5];
  } list = {2, {{1, 6, kNobody}, {2, 6, 1}, {4, 0, kNobody}, {16, 6, kNobody}, {32, 0, kNobody}}};
  if (::setxattr(path("file").c_str(), "system.posix_acl_access", &list, sizeof list, 0) != 0) {
    ASSERT_EQ(errno, ENOTSUP);
    GTEST_SKIP() << "the file system of the scratch folder has no access control lists";
  }
  ASSERT_EQ(mode_of(path("file")), 0660u);
  storage_.create_replacement(path("a"), path("file"));
  EXPECT_EQ(mode_of(path("a")), 0600u);
}

TEST_F(LocalStorage, AReplacementIsPrivateFromItsFirstMoment) {
  write_text("file");
  ASSERT_EQ(::chmod(path("file").c_str(), 0664), 0);
  SystemFaults faults;
  faults.call = "fchown";
  faults.before = [&](std::uint64_t) { EXPECT_EQ(mode_of(path("a")), 0600u); };
  EXPECT_EQ(message_of(faults, [&] { storage_.create_replacement(path("a"), path("file")); }), "");
  EXPECT_EQ(mode_of(path("a")), 0664u);
}

TEST_F(LocalStorage, AGroupThatCannotBeKeptLeavesWhatEverybodyHad) {
  write_text("file");
  const struct {
    mode_t mode;
    mode_t left;
  } cases[] = {{0664, 0644}, {0640, 0600}, {0604, 0600}, {0666, 0666}};
  for (const auto& [mode, left] : cases) {
    ASSERT_EQ(::chmod(path("file").c_str(), mode), 0);
    fs::remove(path("a"));
    SystemFaults faults;
    faults.call = "fchown";
    faults.always = true;
    faults.code = EPERM;
    EXPECT_EQ(message_of(faults, [&] { storage_.create_replacement(path("a"), path("file")); }),
              "");
    EXPECT_EQ(mode_of(path("a")), left) << std::oct << mode;
  }
}

TEST_F(LocalStorage, TemporaryFoldersHaveNamesOfTheirOwn) {
  const TemporaryFile one = create_temporary_folder(storage_, path("a"));
  const TemporaryFile two = create_temporary_folder(storage_, path("a"));
  EXPECT_NE(one.path, two.path);
  for (const TemporaryFile* made : {&one, &two}) {
    EXPECT_EQ(storage_.path_type(made->path), PathType::folder);
    EXPECT_EQ(made->path.find(temporary_prefix(path("a"))), 0u);
  }
}

}  // namespace
}  // namespace octavo
