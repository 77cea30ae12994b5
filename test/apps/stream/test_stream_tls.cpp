#include "raw_socket.h"
#include "streams.h"

#include <gtest/gtest.h>

#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rsa.h>
#include <openssl/x509v3.h>

#include <filesystem>
#include <fstream>

namespace {

using namespace fuse_flow;
using namespace fuse_flow::test;
using stream::Client;
using stream::ReceivedFrame;
using stream::Server;

/** \brief Files with a key, and a certificate for a name that it has signed itself. */
class Certificate {
 public:
  explicit Certificate(const std::string& name, const std::string& alternative)
      : certificate((std::filesystem::temp_directory_path() / ("fuse_flow_" + name + "_certificate.pem")).string()),
        key((std::filesystem::temp_directory_path() / ("fuse_flow_" + name + "_key.pem")).string()) {
    EVP_PKEY* pair = nullptr;
    EVP_PKEY_CTX* context = EVP_PKEY_CTX_new_id(EVP_PKEY_RSA, nullptr);
    EVP_PKEY_keygen_init(context);
    EVP_PKEY_CTX_set_rsa_keygen_bits(context, 2048);
    EVP_PKEY_keygen(context, &pair);
    EVP_PKEY_CTX_free(context);
    X509* x509 = X509_new();
    X509_set_version(x509, 2);
    ASN1_INTEGER_set(X509_get_serialNumber(x509), 1);
    X509_gmtime_adj(X509_getm_notBefore(x509), -3600);
    X509_gmtime_adj(X509_getm_notAfter(x509), 3600);
    X509_set_pubkey(x509, pair);
    X509_NAME* subject = X509_get_subject_name(x509);
    X509_NAME_add_entry_by_txt(subject, "CN", MBSTRING_ASC, reinterpret_cast<const unsigned char*>(name.c_str()), -1,
                               -1, 0);
    X509_set_issuer_name(x509, subject);
    X509_EXTENSION* names = X509V3_EXT_conf_nid(nullptr, nullptr, NID_subject_alt_name, alternative.c_str());
    X509_add_ext(x509, names, -1);
    X509_EXTENSION_free(names);
    X509_sign(x509, pair, EVP_sha256());
    std::FILE* file = std::fopen(certificate.c_str(), "w");
    PEM_write_X509(file, x509);
    std::fclose(file);
    file = std::fopen(key.c_str(), "w");
    PEM_write_PrivateKey(file, pair, nullptr, nullptr, 0, nullptr, nullptr);
    std::fclose(file);
    X509_free(x509);
    EVP_PKEY_free(pair);
  }
  ~Certificate() {
    std::filesystem::remove(certificate);
    std::filesystem::remove(key);
  }
  const std::string certificate, key;
};

stream::ServerOptions withCertificate(const Certificate& certificate) {
  stream::ServerOptions options = anyPort();
  options.certificate = certificate.certificate;
  options.key = certificate.key;
  options.token = "0123456789abcdef";
  return options;
}

class StreamTls : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    ours_ = new Certificate("tls_ours", "IP:127.0.0.1,DNS:localhost");
    other_ = new Certificate("tls_other", "DNS:other.example");
  }
  static void TearDownTestSuite() {
    delete ours_;
    delete other_;
  }
  /** \brief Why a client is not let in, or does not want in. */
  static std::string errorOf(const std::string& link, const stream::ClientOptions& options) {
    Client client(link, options);
    ReceivedFrame frame;
    EXPECT_TRUE(eventually([&] { return !client.status().error.empty(); }));
    EXPECT_EQ(client.status().frames, 0u);
    return client.status().error;
  }
  static inline Certificate *ours_, *other_;
};

TEST_F(StreamTls, FramesArriveByteByByte) {
  Server server(withCertificate(*ours_));
  EXPECT_EQ(server.link().rfind("https://127.0.0.1:", 0), 0u);
  EXPECT_TRUE(server.warnings().empty());
  stream::ClientOptions options = patient();
  options.certificate_authority = ours_->certificate;
  Client client(server.link(), options),
      by_name("wss://localhost:" + std::to_string(server.port()) + "/?token=0123456789abcdef", options);
  ASSERT_TRUE(eventually([&] { return server.status().clients.size() == 2; }));
  for (std::uint64_t number = 0; number < 5; ++number) {
    const auto frame = frameOf(100'000, number);
    server.publish(frame);
    for (Client* each : {&client, &by_name}) {
      ReceivedFrame received;
      ASSERT_TRUE(each->pull(received, kLong));
      EXPECT_EQ(received.message, stream::messageOf(frame).joined());
    }
  }
}

TEST_F(StreamTls, ACertificateThatIsNotTrustedEndsTheAttempt) {
  Server server(withCertificate(*ours_));
  server.publish(frameOf(10, 1));
  EXPECT_NE(errorOf(server.link(), patient()).find("certificate is not trusted"), std::string::npos);
  stream::ClientOptions options = patient();
  options.certificate_authority = other_->certificate;
  EXPECT_NE(errorOf(server.link(), options).find("certificate is not trusted"), std::string::npos);
  options = patient();
  options.verify = false;
  Client client(server.link(), options);
  ReceivedFrame frame;
  EXPECT_TRUE(client.pull(frame, kLong));
}

TEST_F(StreamTls, ACertificateForAnotherNameEndsTheAttempt) {
  Server server(withCertificate(*other_));
  stream::ClientOptions options = patient();
  options.certificate_authority = other_->certificate;
  EXPECT_NE(errorOf(server.link(), options).find("certificate is not trusted"), std::string::npos);
}

TEST_F(StreamTls, WhoSpeaksNoTlsIsNotAnswered) {
  stream::ServerOptions server_options = withCertificate(*ours_);
  server_options.handshake_time = std::chrono::milliseconds(500);
  Server server(server_options);
  stream::ClientOptions options = patient();
  options.token = "0123456789abcdef";
  EXPECT_FALSE(errorOf("ws://127.0.0.1:" + std::to_string(server.port()), options).empty());
  RawSocket silent = RawSocket::to(server.port());
  silent.all();
  RawSocket garbage = RawSocket::to(server.port());
  garbage.send(std::string(1000, '\x16'));
  garbage.all();
  Server plain(anyPort());
  EXPECT_FALSE(errorOf("wss://127.0.0.1:" + std::to_string(plain.port()), options).empty());
  ASSERT_TRUE(eventually([&] { return server.status().connections == 0; }));
  options = patient();
  options.certificate_authority = ours_->certificate;
  Client client(server.link(), options);
  server.publish(frameOf(10, 1));
  ReceivedFrame frame;
  EXPECT_TRUE(client.pull(frame, kLong));
}

TEST_F(StreamTls, FilesThatAreNoneAreNamed) {
  const auto refused = [](const std::string& certificate, const std::string& key, const std::string& named) {
    stream::ServerOptions options = anyPort();
    options.certificate = certificate;
    options.key = key;
    try {
      const Server server(options);
      ADD_FAILURE() << named;
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(std::string(error.what()).rfind(named + ":", 0), 0u) << error.what();
    }
  };
  refused("/nowhere.pem", ours_->key, "/nowhere.pem");
  refused(ours_->certificate, "/nowhere.pem", "/nowhere.pem");
  refused(ours_->key, ours_->key, ours_->key);
  refused(ours_->certificate, other_->key, other_->key);
}

}  // namespace
