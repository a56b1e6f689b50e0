// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <sys/stat.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "tests/recorders/network_rig.h"

namespace trilat {
namespace {

using testing::HasSubstr;

TEST(TlsKeys, OnlyTheirOwnerMayReadThem) {
  const ScratchFolder folder;
  make_tls_keys(folder / "keys", {"k1", "k2"});
  for (const char* file : {"k1.key", "k2.key", "recorder.keys"}) {
    struct stat status {};
    ASSERT_EQ(::stat((folder / "keys" / file).c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0600u) << file;
  }
  TlsKeys all = read_tls_keys(folder / "keys/k1.key");
  EXPECT_EQ(all.size(), 1u);
  all.merge(read_tls_keys(folder / "keys/k2.key"));
  EXPECT_EQ(read_tls_keys(folder / "keys/recorder.keys"), all);
  EXPECT_NE(all.at("k1"), all.at("k2"));
}

TEST(TlsKeys, AgentsAreAddedLaterAndNothingIsOverwritten) {
  const ScratchFolder folder;
  make_tls_keys(folder / "keys", {"k1"});
  const TlsKeys before = read_tls_keys(folder / "keys/k1.key");
  EXPECT_EQ(make_tls_keys(folder / "keys", {"k2"}).size(), 1u);
  EXPECT_THROW(make_tls_keys(folder / "keys", {"k3", "k1"}), InputError);
  EXPECT_FALSE(std::filesystem::exists(folder / "keys/k3.key"));
  EXPECT_EQ(read_tls_keys(folder / "keys/k1.key"), before);
  const TlsKeys all = read_tls_keys(folder / "keys/recorder.keys");
  EXPECT_EQ(all.size(), 2u);
  EXPECT_EQ(all.at("k1"), before.at("k1"));
}

TEST(TlsKeys, NamesThatAreNoFileNamesOrTakenAreRefused) {
  const ScratchFolder folder;
  for (const char* name : {"", "a/b", "..", "k 1"})
    EXPECT_THROW(make_tls_keys(folder / "keys", {name}), InputError) << name;
  EXPECT_THROW(make_tls_keys(folder / "keys", {"k1", "k1"}), InputError);
  EXPECT_FALSE(std::filesystem::exists(folder / "keys"));
}

TEST(TlsKeys, AFileThatOthersMayReadOrThatHoldsSomethingElseIsRefused) {
  const TestKeys keys;
  const auto path = keys.folder / "keys/k1.key";
  const std::string line = read_file(path);
  const auto said_of = [&](const std::string& text) {
    write_file(path, text);
    ::chmod(path.c_str(), 0600);
    return message_of([&] { read_tls_keys(path); });
  };
  for (const std::string& text :
       {line.substr(0, line.size() - 3), line + line, "k 1" + line, "-----BEGIN\n" + line,
        line.substr(0, line.size() - 2) + "x\n", std::string("k1\n")})
    EXPECT_THAT(said_of(text), HasSubstr("64 hexadecimal digits")) << text;
  EXPECT_THAT(said_of(line + line), HasSubstr("k1.key:2: "));
  EXPECT_THAT(said_of(""), HasSubstr("holds no key"));
  EXPECT_EQ(said_of(line), "no error");
  ::chmod(path.c_str(), 0644);
  EXPECT_THAT(message_of([&] { read_tls_keys(path); }), HasSubstr("chmod 600"));
  EXPECT_THROW(read_tls_keys(keys.folder / "keys/none.key"), InputError);
}

TEST(TlsKeys, AnAgentCannotPassForTheRecordingMachine) {
  const TestKeys keys;
  SocketListener listener({"127.0.0.1", 0});
  std::thread impostor([&] {
    auto accepted = listener.accept(kGenerous);
    try {
      secure_link(std::move(accepted->link), keys.of("k2.key"), TlsSide::server, kGenerous);
    } catch (const std::runtime_error&) {
    }
  });
  EXPECT_THROW(connect_as(keys, "k1", listener.port())(), LinkRefused);
  impostor.join();
}

TEST(TlsKeys, AHandshakeThatNobodyWantsAnyMoreEnds) {
  const TestKeys keys;
  SocketListener listener({"127.0.0.1", 0});
  const auto mute = connect_socket({"127.0.0.1", listener.port()}, kGenerous);
  auto accepted = listener.accept(kGenerous);
  EXPECT_THROW(secure_link(std::move(accepted->link), keys.of("recorder.keys"), TlsSide::server, kGenerous,
                           [] { return true; }),
               LinkLost);
}

TEST(SocketAddress, IsHostAndPort) {
  EXPECT_EQ(parse_address("10.0.0.2:7345").host, "10.0.0.2");
  EXPECT_EQ(parse_address("10.0.0.2:7345").port, 7345);
  EXPECT_EQ(parse_address("[::1]:80").host, "::1");
  EXPECT_EQ(parse_address(":80").host, "");
  for (const char* text : {"", "host", "host:", "host:x", "host:65536", "::1", "host:-1", "host:80 "})
    EXPECT_THROW(parse_address(text), InputError) << text;
}

TEST(SocketAddress, OnlyLiteralAddressesAndLocalhostAreThisMachine) {
  for (const char* host : {"localhost", "127.0.0.1", "127.9.8.7", "::1", "::ffff:127.0.0.1"})
    EXPECT_TRUE(is_loopback({host, 1})) << host;
  for (const char* host :
       {"127.example.org", "127.0.0.1.nip.io", "", "10.0.0.1", "::", "127.", "::ffff:10.0.0.1"})
    EXPECT_FALSE(is_loopback({host, 1})) << host;
}

TEST(SocketAddress, PlainTextStaysOnThisMachineUnlessAllowed) {
  EXPECT_THROW(connect_to_server({"192.0.2.1", 1}, {}, false), InputError);
  EXPECT_NO_THROW(connect_to_server({"192.0.2.1", 1}, {}, true));
  ListenOptions listen;
  EXPECT_THROW(NetworkSource{listen}, InputError);
  listen.address = {"127.0.0.1", 0};
  NetworkSource network(listen);
  MadeSource source("kinect", made_events(20));
  RunningAgent agent(source, agent_options("k1"),
                     connect_to_server({"127.0.0.1", network.port()}, {}, false));
  network.wait_for_agents(1, kGenerous);
  EXPECT_EQ(receive_all(network).frames.size(), 20u);
}

}  // namespace
}  // namespace trilat
