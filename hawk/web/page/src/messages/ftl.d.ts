/** A file of messages: the text of the English one, the address of any other. */
declare module "*.ftl" {
  const content: string;
  export default content;
}
